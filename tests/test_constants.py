"""Every constant that a decision rests on is what was measured: who changes one changes it here, who moves it doesn't.

`TOPOMAP_ANSWERS=write pytest tests/test_constants.py` writes tests/golden/stages/constants-*.json anew.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import FunctionType, ModuleType

import numpy as np
import pytest
from kept import as_before
from pydantic import BaseModel
from pydantic.fields import FieldInfo

ROOT = Path(__file__).parents[1]
FOLDERS = ("topomap/mapping", "topomap/navigation", "topomap/recording", "topomap/vision", "logs")


def modules(folder: str) -> Iterator[ModuleType]:
    for path in sorted((ROOT / folder).rglob("[!_]*.py")):
        if not path.name.endswith("_pb2.py"):
            yield importlib.import_module(str(path.relative_to(ROOT).with_suffix("")).replace("/", "."))


def constants(module: ModuleType) -> Iterator[tuple[str, list[float]]]:
    """Yield the numbers of a module's own constants and of its classes' and functions' defaults, by name."""
    names = [name for name in vars(module) if name.lstrip("_").isupper()]
    for name in names:
        if (numbers := flat(getattr(module, name))) is not None:
            yield name, numbers
    for own in list(vars(module).values()):
        if getattr(own, "__module__", "") == module.__name__:
            for name, value in defaults(own):
                if (numbers := flat(value)) is not None:
                    yield name, numbers


def defaults(own: object) -> Iterator[tuple[str, object]]:
    """Yield what stands where nothing is given: a class's fields and its functions' arguments, or a function's."""
    if isinstance(own, type):
        if issubclass(own, BaseModel):
            for name, field in own.model_fields.items():
                yield f"{own.__name__}.{name}", field.default
                yield from ((f"{own.__name__}.{name} {said}", bound) for said, bound in bounds(field))
        elif is_dataclass(own):
            told = [field for field in fields(own) if field.default is not MISSING]
            yield from ((f"{own.__name__}.{field.name}", field.default) for field in told)
        for inner in vars(own).values():
            yield from ((f"{own.__name__}.{name}", value) for name, value in arguments(inner))
    else:
        yield from arguments(own)


def bounds(field: FieldInfo) -> Iterator[tuple[str, object]]:
    """Yield what a setting must keep to: ge, gt, le, lt and the like."""
    for one in field.metadata:
        for said in ("ge", "gt", "le", "lt", "min_length", "max_length", "multiple_of"):
            if (bound := getattr(one, said, None)) is not None:
                yield said, bound


def arguments(function: object) -> Iterator[tuple[str, object]]:
    """Yield a function's defaults, a compiled one's too; those that dataclasses make are their fields'."""
    plain = getattr(function, "py_func", getattr(function, "__func__", function))
    if isinstance(plain, FunctionType) and plain.__name__ != "__init__":
        for name, one in inspect.signature(plain).parameters.items():
            if one.default is not inspect.Parameter.empty:
                yield f"{plain.__name__}.{name}", one.default


def flat(value: object) -> list[float] | None:
    """Return the numbers of a number, an array, a tuple or a dict, None where it holds anything else; of a record or of
    settings the numbers that there are.
    """
    if isinstance(value, (bool, int, float)):
        return [float(value)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiu":
        return [float(one) for one in value.ravel()]
    if not isinstance(value, type) and (is_dataclass(value) or isinstance(value, BaseModel)):
        names = list(type(value).model_fields) if isinstance(value, BaseModel) else [f.name for f in fields(value)]
        return [one for name in names for one in flat(getattr(value, name)) or ()] or None
    if isinstance(value, dict):  # of plain numbers: others are registers, which tests add to, and caches
        value = tuple(value.items()) if all(isinstance(one, (int, float)) for one in value) else None
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
    as_before(f"constants {folder.split('/')[-1]}", told, close=1e-9)  # an inverse has noise in its zeros
