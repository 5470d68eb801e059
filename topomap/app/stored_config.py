"""The configuration that a log keeps, whichever version wrote it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from topomap.app.config import RunConfig, parse_config

RENAMED = (
    ("stack.mapper.correction", "stack.mapper.optimisation"),
    ("stack.mapper.optimisation.neighbours", "stack.mapper.optimisation.sequential"),
    ("stack.mapper.closing.verification", "stack.mapper.closing.appearance"),
    ("stack.mapper.closing.likeness", "stack.mapper.closing.same_place"),
    ("stack.mapper.closing.quorum", "stack.mapper.closing.voting"),
)
"""Sections' old names and the names they got, in the order in which that happened."""
DEFAULTS = Path(__file__).with_name("defaults_0_1.toml")


def parse_stored(
    values: Mapping[str, Any], source: str, overrides: Iterable[str] = ()
) -> tuple[RunConfig, tuple[str, ...]]:
    """Return a log's configuration, changed by `section.key=value` words, and a line for each setting that is lost.

    Sections that were renamed keep their values; a setting that is no more is left out, and told where the log asks
    for another value than the default it had. Raises ConfigError for values that are wrong.
    """
    kept: dict[str, Any] = {}
    lost = []
    for path, value in _flat(values):
        path = _renamed(path)
        if _known(path):
            _put(kept, path, value)
        elif value != first_defaults().get(path) and value is not None:
            lost.append(f"the log asks for {'.'.join(path)} = {value!r}, which is no setting any more: it is left out")
    return parse_config(kept, source, overrides), tuple(lost)


def _flat(values: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, (*path, name))
        else:
            yield (*path, name), value


def _renamed(path: tuple[str, ...]) -> tuple[str, ...]:
    text = ".".join(path)
    for old, new in RENAMED:
        if text.startswith(f"{old}."):
            text = new + text.removeprefix(old)
    return tuple(text.split("."))


def _known(path: tuple[str, ...]) -> bool:
    """Return whether the configuration has a setting of this path today."""
    model: Any = RunConfig
    for name in path:
        if not (isinstance(model, type) and issubclass(model, BaseModel) and name in model.model_fields):
            return False
        model = model.model_fields[name].annotation
    return True


def _put(values: dict[str, Any], path: tuple[str, ...], value: Any) -> None:
    for name in path[:-1]:
        values = values.setdefault(name, {})
    values[path[-1]] = value


@cache
def first_defaults() -> dict[tuple[str, ...], Any]:
    """Return the defaults of version 0.1 by path."""
    return dict(_flat(tomllib.loads(DEFAULTS.read_text(encoding="utf8"))))
