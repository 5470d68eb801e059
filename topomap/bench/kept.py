"""Results as JSON and back, told by their types alone: what is read can hold values and never run code."""

from __future__ import annotations

import base64
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

ENDINGS = ("f", "i", "u", "b")
"""Kinds of NumPy numbers that are kept."""


def to_plain(value: object) -> Any:  # Any: JSON
    """Return a result as JSON values; arrays keep every bit. Raises TypeError for a kind of value that isn't kept."""
    if isinstance(value, np.ndarray):
        data = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
        return {"dtype": value.dtype.str, "shape": list(value.shape), "data": data}
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if is_dataclass(value):
        return {field.name: to_plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(name): to_plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item) for item in value]
    raise TypeError(f"{type(value).__name__} isn't kept")


def from_plain(kind: Any, value: Any) -> Any:  # Any: types as values, JSON
    """Return the result of a type from its JSON values. Raises ValueError, KeyError or TypeError where they differ."""
    origin, args = get_origin(kind), get_args(kind)
    if kind is Any or kind is None or kind is types.NoneType:
        return value
    if origin is np.ndarray:
        return _array(value)
    if origin in (Union, types.UnionType):
        inner = [arg for arg in args if arg is not types.NoneType]
        return None if value is None else from_plain(inner[0], value) if len(inner) == 1 else value
    if is_dataclass(kind) and isinstance(kind, type):
        hints = get_type_hints(kind)
        return kind(**{field.name: from_plain(hints[field.name], value[field.name]) for field in fields(kind)})
    if origin is tuple:
        each = [args[0]] * len(value) if len(args) == 2 and args[1] is Ellipsis else args
        return tuple(from_plain(one, item) for one, item in zip(each, value, strict=True))
    if origin is list:
        return [from_plain(args[0], item) for item in value]
    if origin in (dict, Mapping) or kind is dict:
        return {name: from_plain(args[1] if args else Any, item) for name, item in value.items()}
    if kind in (bool, int, float, str):
        return _scalar(kind, value)
    raise TypeError(f"{kind} isn't kept")


def _scalar(kind: type, value: Any) -> Any:
    if not isinstance(value, kind) and not (kind is float and isinstance(value, int)):
        raise ValueError(f"{value!r} is no {kind.__name__}")
    return value


def _array(value: Any) -> Any:
    dtype = np.dtype(value["dtype"])
    if dtype.kind not in ENDINGS:
        raise ValueError(f"arrays of {dtype} aren't kept")
    return np.frombuffer(base64.b64decode(value["data"]), dtype).reshape(value["shape"]).copy()
