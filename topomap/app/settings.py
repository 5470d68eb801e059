"""The settings for people: as TOML with meaning, bounds and defaults, and as a JSON schema."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import get_args

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from topomap.app.config import RunConfig

SIGNS = {Ge: ">=", Gt: ">", Le: "<=", Lt: "<"}


def settings_toml(config: RunConfig, flaws: bool = True) -> str:
    """Return a configuration as TOML that `--config` reads, each setting under a comment that says what it means.

    flaws: also by what the simulated robot can be made worse, and isn't; what is set is always there.
    """
    head = "# Settings of a run; leave out what shall keep its default. One for a single run: --set section.key=value"
    default = RunConfig()
    lines = list(_section(config, default, (), flaws))
    if left := 0 if flaws else _count(_section(config, default, (), True)) - _count(lines):
        lines += ["", f"# {left} more by which the simulated robot can be made worse: topomap config show --all"]
    return "\n".join([head, *lines]) + "\n"


def settings_schema() -> str:
    """Return the JSON schema of a configuration."""
    return json.dumps(RunConfig.model_json_schema(), indent=2)


def _section(section: BaseModel, default: BaseModel, path: tuple[str, ...], flaws: bool) -> Iterator[str]:
    """Yield the lines of a section and of those in it; default: the section as it is when nothing is set."""
    fields = type(section).model_fields
    rows = [(name, getattr(section, name), getattr(default, name)) for name in fields]
    if not flaws:
        rows = [row for row in rows if row[0] not in getattr(section, "FLAWS", ()) or row[1] != row[2]]
    plain = [row for row in rows if not isinstance(row[1], BaseModel)]
    if plain:
        yield from ("", f"[{'.'.join(path)}]")
    for name, value, usual in plain:
        yield from _setting(name, value, usual, fields[name])
    for name, value, usual in rows:
        if isinstance(value, BaseModel):
            yield from _section(value, usual, (*path, name), flaws)


def _count(lines: Iterable[str]) -> int:
    """Return how many settings the lines show: each has a comment that ends in its default."""
    return sum(line.startswith("# ") and "default " in line for line in lines)


def _setting(name: str, value: object, usual: object, field: FieldInfo) -> Iterator[str]:
    """Yield a setting's comment and line; TOML has no null, so what isn't set is a comment as well."""
    yield f"# {field.description or name} ({'; '.join(_allowed(field, usual))})"
    yield f"# {name} is not set" if value is None else f"{name} = {_toml(value)}"


def _allowed(field: FieldInfo, usual: object) -> Iterator[str]:
    """Yield bounds, choices and default in words."""
    marks = [mark for mark in field.metadata if type(mark) in SIGNS]
    if marks:
        yield " and ".join(f"{SIGNS[type(mark)]} {_bound(mark)}" for mark in marks)
    choices = [_toml(choice) for choice in get_args(field.annotation) if isinstance(choice, str)]
    if choices:
        yield " or ".join(choices)
    yield f"default {'none' if usual is None else _toml(usual)}"


def _bound(mark: object) -> str:
    assert isinstance(mark, Ge | Gt | Le | Lt)
    return str(next(getattr(mark, name) for name in ("ge", "gt", "le", "lt") if hasattr(mark, name)))


def _toml(value: object) -> str:
    if isinstance(value, BaseModel):
        value = value.model_dump(mode="json", exclude_none=True)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{name} = {_toml(item)}" for name, item in value.items()) + "}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return json.dumps(value, ensure_ascii=False)  # bools, numbers and text are written alike in JSON and TOML
