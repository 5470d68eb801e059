"""The map file: loads back equal, or says in one line what is wrong."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from maps import RIG, STEP_NS, square

from topomap.core.errors import DataError
from topomap.mapping.mapfile import from_bytes, load_map, save_map, to_bytes
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import TurnEdge


def test_a_map_loads_back_equal(tmp_path: Path) -> None:
    topo = square()
    topo.insert(7 * STEP_NS)
    topo.calibration = Calibration(1.04, 0.003, 0.95)
    topo.turns += [TurnEdge(0, 1, 0.1, 0.01), TurnEdge(1, 2, -1 / 3, 1 / 7)]
    save_map(topo, tmp_path / "a.topomap")
    loaded = load_map(tmp_path / "a.topomap")
    assert loaded.hash([]) == topo.hash([])
    assert loaded.calibration == topo.calibration
    assert to_bytes(loaded) == to_bytes(topo)
    assert loaded.turns == topo.turns
    assert sorted(loaded.graph.edges) == sorted(topo.graph.edges)
    assert loaded.trajectory()[1].tolist() == topo.trajectory()[1].tolist()
    first, second = loaded.nodes[3].snapshot, topo.nodes[3].snapshot
    assert first is not None
    assert second is not None
    assert first.rig == second.rig
    assert first.ranges is not None
    assert first.ranges.tolist() == [3.0] * 72


def test_a_map_of_the_first_format_loads_without_turns() -> None:
    topo = square()
    topo.turns.append(TurnEdge(0, 1, 0.1, 0.01))
    loaded = from_bytes(first_format(to_bytes(topo)))
    assert loaded.hash([]) == topo.hash([])
    assert loaded.turns == []


def first_format(data: bytes, number: int = 1) -> bytes:
    """The bytes as the first house wrote them: another number, no turns, no numbers, ranges row by row."""
    with np.load(io.BytesIO(data)) as file:
        arrays = {name: file[name] for name in file.files if not name.startswith(("turn", "names", "jumps"))}
    arrays["ranges"] = arrays["ranges"].reshape(-1, RIG.width)
    meta = json.loads(arrays["meta"].tobytes()) | {"format": number}
    arrays["meta"] = np.frombuffer(json.dumps(meta).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


@pytest.mark.parametrize("damage", [b"", b"not a map", None])
def test_a_damaged_map_is_one_clear_line(tmp_path: Path, damage: bytes | None) -> None:
    path = tmp_path / "a.topomap"
    save_map(square(), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    with pytest.raises(DataError, match=r"a\.topomap: not a topomap map, or damaged") as error:
        load_map(path)
    assert "\n" not in str(error.value)


def test_a_missing_map_and_an_unwritable_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="can't be read"):
        load_map(tmp_path / "none.topomap")
    with pytest.raises(DataError, match="can't be written"):
        save_map(square(), tmp_path / "none" / "a.topomap")
