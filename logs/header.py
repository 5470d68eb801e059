"""The header of a log: all that is known before the first step."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TypeVar

from logs.records import Pose

R = TypeVar("R")
FORMAT = "1"
RUN = "topomap.run"
VERSIONS = "topomap.versions"
CONFIG = "config.json"
PLAN = "plan.json"
WHOLE = "header.json"
"""All of the header once more, with a checksum: metadata have none, and one flipped bit mustn't cost a log."""


@dataclass(frozen=True, slots=True)
class Rig:
    """How the panorama was taken: pixels, metres; see `topomap.core.robot.RigReading`."""

    width: int
    height: int
    horizon_row: float
    focal: float
    camera_height: float
    forward_column: int
    clockwise: bool


@dataclass(frozen=True, slots=True)
class Errors:
    """The odometer's true systematic errors, None where unknown; curvature [rad/m]."""

    rotation_scale: float | None = None
    distance_scale: float | None = None
    curvature: float | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """A world's plan in the truth's frame: polylines, circles (x, y, r), labels (x, y, text) [m]."""

    polylines: tuple[tuple[tuple[float, float], ...], ...] = ()
    circles: tuple[tuple[float, float, float], ...] = ()
    labels: tuple[tuple[float, float, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Header:
    """A run before its first step; config: the resolved settings as JSON; start: the true pose, if known."""

    world: str
    rig: Rig
    seed: int | None = None
    config: str = "{}"
    versions: Mapping[str, str] = field(default_factory=dict)
    start: Pose | None = None
    errors: Errors = field(default_factory=Errors)
    plan: Plan = field(default_factory=Plan)
    replayed: bool = False

    def run(self) -> dict[str, str]:
        """Return the metadata record `topomap.run`: JSON values by name."""
        values = {
            "world": self.world,
            "seed": self.seed,
            "rig": asdict(self.rig),
            "start": None if self.start is None else asdict(self.start),
            "errors": asdict(self.errors),
            "replayed": self.replayed,
        }
        return {"format": FORMAT} | {name: json.dumps(value) for name, value in values.items()}

    def plan_json(self) -> bytes:
        """Return the attachment `plan.json`."""
        return json.dumps(asdict(self.plan)).encode()

    def whole_json(self) -> bytes:
        """Return the attachment `header.json`: all of the above once more."""
        versions = dict(sorted(self.versions.items()))
        whole = {"run": self.run(), "versions": versions, "config": self.config, "plan": self.plan_json().decode()}
        return json.dumps(whole).encode()

    @staticmethod
    def of_whole(data: bytes) -> Header:
        """Return the header of the attachment `header.json`; raises ValueError, KeyError, TypeError, RecursionError."""
        whole = json.loads(data)
        return Header.of(whole["run"], whole["versions"], whole["config"].encode(), whole["plan"].encode())

    @staticmethod
    def of(run: Mapping[str, str], versions: Mapping[str, str], config: bytes, plan: bytes) -> Header:
        """Return the header of what was stored; raises ValueError, KeyError, TypeError, RecursionError."""
        if run["format"] != FORMAT:
            raise ValueError(f"log format {run['format']}, this version reads {FORMAT}")
        names = ("world", "seed", "rig", "start", "errors", "replayed")
        values = {name: json.loads(run[name]) for name in names}
        return Header(
            world=str(values["world"]),
            rig=_numbers(Rig(**values["rig"])),
            seed=None if values["seed"] is None else int(values["seed"]),
            config=config.decode(),
            versions=dict(versions),
            start=None if values["start"] is None else _numbers(Pose(**values["start"])),
            errors=_numbers(Errors(**values["errors"])),
            plan=_plan(plan),
            replayed=bool(values["replayed"]),
        )


def _numbers(record: R) -> R:
    """Return a record of numbers, or None, as it is; raises ValueError where it holds anything else."""
    for name, value in asdict(record).items():  # type: ignore[call-overload]
        if value is not None and not isinstance(value, int | float):
            raise ValueError(f"{name} = {str(value)[:70]!r} is no number")
    return record


def _plan(data: bytes) -> Plan:
    raw = json.loads(data)
    return Plan(
        tuple(tuple((x, y) for x, y in line) for line in raw["polylines"]),
        tuple((x, y, r) for x, y, r in raw["circles"]),
        tuple((x, y, text) for x, y, text in raw["labels"]),
    )
