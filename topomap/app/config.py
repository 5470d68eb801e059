"""The configuration of a run: sections of the stack, the simulator and the log, read by one strict loader."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any, Self, TypeGuard, get_args

from pydantic import BaseModel, Field, ValidationError, model_validator

from logs.config import LogConfig
from sim2d.config import SimConfig
from topomap.core import files
from topomap.core.errors import ConfigError
from topomap.mapping.mapper import MapperSettings
from topomap.navigation.manoeuvres.active_check import ActiveSettings
from topomap.navigation.manoeuvres.hall_course import HallSettings
from topomap.navigation.mission import MissionSettings
from topomap.navigation.traveller import TravelSettings

LARGEST = 1e9
"""No setting is larger: seconds of thirty years."""
DEEPEST = 16  # parts of a key: settings have 4
LONGEST = 70  # characters of a value that are shown


class StackConfig(BaseModel, frozen=True, extra="forbid"):
    """The stack's settings."""

    mapper: MapperSettings = MapperSettings()
    mission: MissionSettings = MissionSettings()
    travel: TravelSettings = TravelSettings()
    active: ActiveSettings = ActiveSettings()
    hall: HallSettings = HallSettings()


class RunConfig(BaseModel, frozen=True, extra="forbid"):
    """All settings of a run; `resolved` is what is stored in its log."""

    stack: StackConfig = Field(default_factory=StackConfig)
    sim: SimConfig = Field(default_factory=SimConfig)
    log: LogConfig = Field(default_factory=LogConfig)

    @model_validator(mode="after")
    def _a_range_for_each_column(self) -> Self:
        rays, columns = self.sim.laser.rays, self.sim.camera.width
        if self.sim.laser.scanner != "none" and rays not in (None, columns):
            raise ValueError(f"sim.laser.rays={rays}: expected {columns}, a range for each column (sim.camera.width)")
        return self

    def resolved(self) -> dict[str, Any]:
        """Return the settings as plain JSON values."""
        return self.model_dump(mode="json")


def load_config(path: Path | None = None, overrides: Iterable[str] = ()) -> RunConfig:
    """Return the defaults, changed by a TOML file and then by `section.key=value` words.

    Raises ConfigError with one line that names the file or word, the key, the value and what would be right.
    """
    return parse_config(read_toml(path) if path else {}, str(path), overrides)


def parse_config(values: dict[str, Any], source: str, overrides: Iterable[str] = ()) -> RunConfig:
    """Return the configuration of plain values, as a file or a log holds them, changed by `section.key=value` words.

    Raises ConfigError.
    """
    try:
        return _changed(values, source, tuple(overrides))
    except RecursionError as error:
        raise ConfigError(f"{source}: its values are nested too deeply") from error


def _changed(values: dict[str, Any], source: str, words: tuple[str, ...]) -> RunConfig:
    changed = deepcopy(values)
    for word in words:
        _set(changed, word)
    try:
        return _parse(changed, source)
    except ConfigError:
        _parse(values, source)  # alone, so that a mistake in the source is blamed on it
        for word in words:
            _set(values, word)
            _parse(values, f"--set {_cut(word)}")
        raise


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file. Raises ConfigError with one line that names it."""
    try:
        return files.read_toml(path)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or error}") from error
    except RecursionError as error:
        raise ConfigError(f"{path}: its tables are nested too deeply") from error
    except ValueError as error:  # not TOML, not UTF-8, a number of a million digits
        raise ConfigError(f"{path}: not a TOML file: {error}") from error


def _set(values: dict[str, Any], word: str) -> None:
    key, equals, text = word.partition("=")
    names = key.strip().split(".")
    if not equals or not all(names) or len(names) > DEEPEST:
        raise ConfigError(f"--set {_cut(word)}: expected section.key=value, as in stack.mapper.snapshots.threshold=0.7")
    for name in names[:-1]:
        values = values.setdefault(name, {})
        if not isinstance(values, dict):
            raise ConfigError(f"--set {_cut(word)}: {name} is a value, not a section")
    values[names[-1]] = _value(text.strip())


def _cut(word: str) -> str:
    return word if len(word) <= LONGEST else f"{word[:LONGEST]}..."


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except RecursionError as error:
        raise ConfigError(f"--set: a value is nested too deeply: {text[:LONGEST]}...") from error
    except ValueError:  # no TOML: a word without quotes
        return text


def _parse(values: dict[str, Any], source: str) -> RunConfig:
    for path, number in _numbers(values):
        if not abs(number) <= LARGEST:
            raise ConfigError(f"{source}: {path} = {_short(number)}: no setting is NaN, infinite or beyond {LARGEST:g}")
    try:
        return RunConfig.model_validate(values)
    except ValidationError as error:
        raise ConfigError(f"{source}: {_one_line(error)}") from error


def _one_line(error: ValidationError) -> str:
    first = error.errors()[0]
    path = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        known = _keys(first["loc"][:-1])
        return f"unknown key {path}" + (f"; known there: {', '.join(known)}" if known else "")
    said = f"{first['msg'][0].lower()}{first['msg'][1:]}".removeprefix("value error, ")
    # what several settings have to do with one another is said by its own words
    return f"{path} = {_short(first['input'])}: {said}" if path else said


def _short(value: object) -> str:
    """Return a value on one line, cut where it is long."""
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > LARGEST:
        return "a number of more digits than one can read"
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _numbers(values: object, path: str = "") -> Iterator[tuple[str, int | float]]:
    """Yield every number in nested tables and lists with where it stands."""
    inside: Iterable[tuple[object, object]] = ()
    if isinstance(values, dict):
        inside = values.items()
    elif isinstance(values, list | tuple):
        inside = enumerate(values)
    elif isinstance(values, int | float):
        yield path, values
    for name, value in inside:
        yield from _numbers(value, f"{path}.{name}" if path else str(name))


def _keys(path: tuple[int | str, ...]) -> list[str]:
    """Return the keys that are known in a table of the settings, one in a list included; none where it isn't one."""
    model: object = RunConfig
    for name in path:
        if isinstance(name, str):
            model = _table(model.model_fields[name].annotation) if _is_table(model) else None
    return sorted(model.model_fields) if _is_table(model) else []


def _table(annotation: object) -> object:
    """Return the table that a field holds, as it is or in a list of them."""
    return next((one for one in (annotation, *get_args(annotation)) if _is_table(one)), None)


def _is_table(thing: object) -> TypeGuard[type[BaseModel]]:
    return isinstance(thing, type) and issubclass(thing, BaseModel)
