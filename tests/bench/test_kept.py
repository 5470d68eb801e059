"""Results are kept as JSON by their types: every bit comes back, and nothing that is read can run code."""

from __future__ import annotations

import json
import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from topomap.bench.homing.field import HomeField, Survey, Turns
from topomap.bench.homing.walk import Walk
from topomap.bench.kept import from_plain, to_plain
from topomap.bench.places import PlaceScore
from topomap.bench.pool import Store, workers
from topomap.core.records import Plan

PLAN = Plan((np.array([[0.0, 1.0], [2.0, 3.5]]),), ((1.0, 2.0, 0.5),), ((0.5, 0.5, "door"),))
RESULTS = (
    Survey("hall", np.random.default_rng(0).normal(size=(5, 2)), 0.3, (1.0, 2.0), PLAN, True, False),
    Turns(np.array([0.1, np.nan]), np.array([np.inf, -0.0]), np.array([5e-324, 1e308])),
    HomeField(np.zeros(0), np.ones(2), (Walk(np.eye(2), True),), None),
    HomeField(np.zeros(0), np.ones(2), (), "it has no ranges"),
    PlaceScore("min-warping", 3, 0.1, 0.2, 1.0, float("nan"), 0.5),
)


def same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if hasattr(a, "__dataclass_fields__"):
        return type(a) is type(b) and all(same(getattr(a, n), getattr(b, n)) for n in a.__dataclass_fields__)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(same, a, b))
    return repr(a) == repr(b)


@pytest.mark.parametrize("result", RESULTS, ids=lambda result: type(result).__name__)
def test_every_bit_comes_back(result: object) -> None:
    assert same(from_plain(type(result), json.loads(json.dumps(to_plain(result)))), result)


def test_other_values_than_the_type_says_are_refused() -> None:
    for kind, value in ((int, "3"), (str, 3), (bool, 1), (float, "x"), (tuple[int, int], [1]), (PlaceScore, {}),
                        (NDArray[np.float64], {"dtype": "O", "shape": [1], "data": ""})):  # fmt: skip
        with pytest.raises((ValueError, KeyError, TypeError)):
            from_plain(kind, value)
    assert from_plain(float, 3) == 3
    assert from_plain(Mapping[str, Any], {"a": [1, None]}) == {"a": [1, None]}
    assert from_plain(dict[str, int], {"a": 1}) == {"a": 1}
    assert from_plain(list[int | None], [1, None]) == [1, None]
    with pytest.raises(TypeError, match="isn't kept"):
        to_plain({1, 2})


@dataclass(frozen=True)
class Squares:
    """A task that says how often it was done."""

    count: int
    done: list[int]

    @property
    def key(self) -> str:
        return f"squares {self.count}"

    def perform(self) -> tuple[int, ...]:
        self.done.append(1)
        return tuple(k * k for k in range(self.count))


class Trap:
    def __reduce__(self) -> tuple[object, tuple[int]]:
        return exit, (9,)


@pytest.mark.parametrize("spoilt", [b"", b"{", b"[1, 2", b"[" * 100_000, pickle.dumps(Trap()), b'["a"]', b"null"])
def test_what_was_kept_is_read_once_more_and_what_was_spoilt_is_made_anew(tmp_path: Path, spoilt: bytes) -> None:
    task = Squares(3, [])
    for _ in range(2):
        with workers(1, Store(tmp_path)) as hands:
            assert hands.run([task], lambda: None) == [(0, 1, 4)]
        assert len(task.done) == 1
    (kept,) = (path for path in tmp_path.rglob("*") if path.is_file())
    assert json.loads(kept.read_text()) == [0, 1, 4]
    kept.write_bytes(spoilt)
    with workers(1, Store(tmp_path)) as hands:
        assert hands.run([task], lambda: None) == [(0, 1, 4)]
    assert len(task.done) == 2
    Store(tmp_path).forget(task.key)
    assert Store(tmp_path).get(task) is None


def test_no_pickle_is_read_anywhere() -> None:
    root = Path(__file__).parents[2]
    sources = [path for name in ("topomap", "sim2d", "logs") for path in (root / name).rglob("*.py")]
    assert len(sources) > 300
    readers = ("import pickle", "from pickle", "import shelve", "import marshal", "allow_pickle=True", "joblib")
    assert [str(path) for path in sources if any(word in path.read_text() for word in readers)] == []
