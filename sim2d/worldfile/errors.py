"""What is wrong with a world file, in one line: FILE: TABLE[index or name].FIELD = VALUE: what would be right."""

from __future__ import annotations

from types import UnionType
from typing import Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from sim2d.errors import WorldError
from sim2d.worldfile.scenes import WorldTable

Raw = dict[str, object]
LONGEST = 70  # characters of a value that are shown


class Fault(Exception):
    """A mistake at `where` (table and field): the value and what would be right."""

    def __init__(self, where: str, value: object, right: str) -> None:
        super().__init__(where)
        self.where, self.value, self.right = where, value, right

    def within(self, source: str) -> WorldError:
        """Return the error for the user, with the file's name."""
        return WorldError(f"{source}: {self.where} = {shown(self.value)}: {self.right}")


def shown(value: object) -> str:
    """Return a value on one line, cut where it is long; a missing one is `nothing`."""
    if value is None:
        return "nothing"
    text = (
        " ".join(repr(value).replace("(", "[").replace(")", "]").split()) if not isinstance(value, str) else repr(value)
    )
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def fault_of(error: ValidationError, raw: Raw) -> Fault:
    """Return the first mistake that the tables' own rules found."""
    first = error.errors()[0]
    loc = first["loc"]
    where = _where(loc, raw)
    if first["type"] == "extra_forbidden":
        return Fault(where, first["input"], f"unknown key; known here: {', '.join(_keys(loc[:-1]))}")
    if first["type"] == "missing":
        return Fault(where, None, "this must be given")
    message = first["msg"].removeprefix("Value error, ")
    return Fault(where, first["input"], message[0].lower() + message[1:])


def _where(loc: tuple[int | str, ...], raw: Raw) -> str:
    """Return a place in the file; rows of a table are called by name, else by number."""
    text, node = "", raw
    for part in loc:
        node = _inside(node, part)
        if isinstance(part, int):
            name = node.get("name") if isinstance(node, dict) else None
            text += f"[{name or part}]"
        else:
            text += f".{part}" if text else part
    return text


def _inside(node: object, part: int | str) -> Raw:
    """Return what lies in a table or list under a key, or an empty table."""
    found: object = None
    if isinstance(node, dict) and isinstance(part, str):
        found = node.get(part)
    elif isinstance(node, list) and isinstance(part, int) and part < len(node):
        found = node[part]
    return found if isinstance(found, dict | list) else {}  # type: ignore[return-value]


def _keys(loc: tuple[int | str, ...]) -> list[str]:
    """Return the keys that are known in a table."""
    model: object = WorldTable
    for part in loc:
        if isinstance(model, type) and issubclass(model, BaseModel) and isinstance(part, str):
            model = _element(model.model_fields[part].annotation)
    return sorted(model.model_fields) if isinstance(model, type) and issubclass(model, BaseModel) else []


def _element(annotation: object) -> object:
    """Return the table that a field holds: itself, an element of its tuple or mapping, or what is not None."""
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is tuple:
        return _element(args[0])
    if origin is dict:
        return _element(args[1])
    if origin in (Union, UnionType):
        return _element(args[0])
    return annotation
