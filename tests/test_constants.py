"""Every constant that a decision rests on is what was measured: who changes one changes it here, who moves it doesn't.

`TOPOMAP_ANSWERS=write pytest tests/test_constants.py` writes tests/golden/stages/constants-*.json anew.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from kept import as_before
from pydantic import BaseModel

ROOT = Path(__file__).parents[1]
FOLDERS = ("topomap/mapping", "topomap/navigation", "topomap/recording", "logs")


def modules(folder: str) -> Iterator[ModuleType]:
    for path in sorted((ROOT / folder).rglob("[!_]*.py")):
        if not path.name.endswith("_pb2.py"):
            yield importlib.import_module(str(path.relative_to(ROOT).with_suffix("")).replace("/", "."))


def constants(module: ModuleType) -> Iterator[tuple[str, list[float]]]:
    """Yield the numbers of a module's own constants and of its classes' defaults, by name."""
    names = [name for name in vars(module) if name.lstrip("_").isupper()]
    for name in names:
        if (numbers := flat(getattr(module, name))) is not None:
            yield name, numbers
    for own in list(vars(module).values()):
        if isinstance(own, type) and own.__module__ == module.__name__:
            for name, value in defaults(own):
                if (numbers := flat(value)) is not None:
                    yield f"{own.__name__}.{name}", numbers


def defaults(own: type) -> Iterator[tuple[str, object]]:
    if issubclass(own, BaseModel):
        yield from ((name, field.default) for name, field in own.model_fields.items())
    elif is_dataclass(own):
        yield from ((field.name, field.default) for field in fields(own) if field.default is not MISSING)


def flat(value: object) -> list[float] | None:
    """Return the numbers of a number, an array or a tuple, None where it holds anything else."""
    if isinstance(value, (bool, int, float)):
        return [float(value)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiu":
        return [float(one) for one in value.ravel()]
    if isinstance(value, tuple) and value:
        parts = [flat(one) for one in value]
        return None if any(part is None for part in parts) else [one for part in parts for one in part or ()]
    return None


@pytest.mark.parametrize("folder", FOLDERS)
def test_they_are_as_before(folder: str) -> None:
    found: dict[str, list[list[float]]] = {}
    for module in modules(folder):
        for name, numbers in constants(module):
            found.setdefault(name, []).append(numbers)
    assert found
    told = {name: [one for numbers in sorted(found[name]) for one in numbers] for name in sorted(found)}
    as_before(f"constants {folder.split('/')[-1]}", told, close=0.0)
