"""World files: a world as a TOML file, checked strictly."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from sim2d.errors import WorldError
from sim2d.files import read_toml
from sim2d.shapes import Spec
from sim2d.worldfile.checks import check_room, check_tables
from sim2d.worldfile.errors import Fault, Raw, fault_of
from sim2d.worldfile.scenes import WorldTable
from sim2d.worldfile.spec import spec_of

SHIPPED = Path(__file__).parents[1] / "worlds"
DEEPEST = 8


def load(path: Path | str) -> Spec:
    """Return the world of a TOML file.

    Raises WorldError with one line `FILE: TABLE[index or name].FIELD = VALUE: what would be right`.
    """
    path = Path(path)
    try:
        return parse(_with_base(path, DEEPEST))
    except Fault as fault:
        raise fault.within(str(path)) from fault


def parse(raw: Raw) -> Spec:
    """Return the world of plain TOML values. Raises Fault."""
    try:
        table = WorldTable.model_validate(raw)
    except ValidationError as error:
        raise fault_of(error, raw) from error
    check_tables(table)
    spec = spec_of(table)
    check_room(table, spec)
    return spec


def _with_base(path: Path, depth: int) -> Raw:
    """Return a file's values on top of those of the file that it extends."""
    raw = _read(path)
    found = _base(path, raw)
    if found is None:
        return raw
    if depth == 0:
        raise Fault("extends", raw["extends"], "files extend one another in a circle")
    return _merged(_with_base(found, depth - 1), raw)


def sources(path: Path) -> tuple[Path, ...]:
    """Return a world file and every file that it extends. Raises WorldError."""
    files = [path]
    try:
        while (found := _base(files[-1], _read(files[-1]))) is not None and len(files) <= DEEPEST:
            files.append(found)
    except Fault as fault:
        raise fault.within(str(path)) from fault
    return tuple(files)


def _base(path: Path, raw: Raw) -> Path | None:
    """Return the file that a file's values extend, None for none. Raises Fault."""
    base = raw.get("extends")
    if not isinstance(base, str) or not base:
        return None
    beside = path.parent / base
    found = beside if beside.suffix == ".toml" else SHIPPED / f"{base}.toml"
    if not found.is_file():
        raise Fault("extends", base, f"there is no {found}; name a shipped world or a file beside this one")
    return found


def _merged(base: Raw, own: Raw) -> Raw:
    """Return both: lists one behind the other, tables of names together, other values from the own file."""
    out = dict(base)
    for key, value in own.items():
        before = out.get(key)
        if isinstance(before, list) and isinstance(value, list) and value and isinstance(value[0], dict):
            out[key] = [*before, *value]
        elif isinstance(before, dict) and isinstance(value, dict) and key in ("places", "routes"):
            out[key] = {**before, **value}
        else:
            out[key] = value
    return out


def _read(path: Path) -> Raw:
    try:
        return read_toml(path)
    except OSError as error:
        raise WorldError(f"{path}: cannot be read: {error.strerror or error}") from error
    except RecursionError as error:
        raise WorldError(f"{path}: its tables are nested too deeply") from error
    except ValueError as error:  # not TOML, not UTF-8, a number of a million digits
        raise WorldError(f"{path}: not a TOML file: {error}") from error
