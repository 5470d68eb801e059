"""How firmly a recording's map stands: other settings, another starting curvature, a tenth of the loop candidates."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from topomap.datasets.tuc.mapping import map_tuc
from topomap.datasets.tuc.recording import TucRecording, read_tuc
from topomap.evaluation.closures import count
from topomap.evaluation.rows import rows_csv
from topomap.evaluation.trajectory import ate
from topomap.mapping.drive_engine import AlongSettings

BY = 0.2  # a setting is moved by this share, either way
CURVATURES = (-0.005, 0.005)  # [rad/m] by which the starting curvature is off
TENTH, DRAWS = 0.1, 5
UNMOVED = ("start_curvature", "axis_sigma_deg", "straight")  # moved otherwise, or not at work


@dataclass(frozen=True, slots=True)
class Variation:
    """One way to map a recording; draw: the seed of a random tenth of the candidates, None for all of them."""

    group: str
    name: str
    settings: AlongSettings
    draw: int | None = None


@dataclass(frozen=True, slots=True)
class RecordingRow:
    """What came of a variation: ATE [m]; closures kept, false (over 2 m off), gross (over 5 m). None without truth."""

    group: str
    name: str
    se2_m: float | None
    sim2_m: float | None
    kept: int
    false: int | None
    gross: int | None
    rotation_scale: float
    curvature: float
    seconds: float


@dataclass(frozen=True, slots=True)
class RecordingTask:
    """Map a recording one way: a pool Task."""

    path: Path
    variation: Variation

    @property
    def key(self) -> str:
        """All that decides the result but the recording itself."""
        return repr((str(self.path), self.variation))

    def perform(self) -> RecordingRow:
        """Map and judge."""
        recording, v = read_tuc(self.path), self.variation
        if v.draw is not None:
            recording = thinned(recording, TENTH, np.random.default_rng(v.draw))
        begin = time.perf_counter()
        run = map_tuc(recording, v.settings)
        seconds = time.perf_counter() - begin
        found, believed = count(run), run.calibration
        assert believed is not None
        rigid = None if run.truth is None else ate(run.final, run.truth)
        scaled = None if run.truth is None else ate(run.final, run.truth, scale=True)
        return RecordingRow(
            v.group, v.name, rigid, scaled, found.accepted, found.false, found.gross,
            believed.rotation_scale.value, believed.curvature.value, seconds,
        )  # fmt: skip


def thinned(recording: TucRecording, share: float, rng: np.random.Generator) -> TucRecording:
    """Return the recording with a random share of its loop candidates, in their order."""
    count = len(recording.query_ns)
    kept = np.sort(rng.choice(count, round(share * count), replace=False))
    return replace(
        recording,
        query_ns=recording.query_ns[kept],
        match_ns=recording.match_ns[kept],
        similarity=recording.similarity[kept],
    )


def variations() -> list[Variation]:
    """Return the recording as it is, every number among the settings moved by 20 %, and what else is in question."""
    base = AlongSettings()
    moved = [Variation("settings", name, changed) for name, changed in moved_settings(base)]
    curved = [
        Variation("start", f"curvature {k:+g}", base.model_copy(update={"start_curvature": k})) for k in CURVATURES
    ]
    drawn = [Variation("a tenth", f"draw {seed}", base, seed) for seed in range(DRAWS)]
    axes = Variation("assumed", "building axes", base.model_copy(update={"building_axes": True}))
    return [Variation("as it is", "", base), *curved, *drawn, *moved, axes]


def moved_settings(base: AlongSettings) -> Iterator[tuple[str, AlongSettings]]:
    """Yield every number among the settings moved by 20 % down and up, and all of them at once."""
    names = [name for name in _numbers(base.model_dump()) if name not in UNMOVED]
    for up in (False, True):
        for chosen in [[name] for name in names] + [names]:
            plain = base.model_dump()
            for name in chosen:
                _move(plain, name, up)
            label = chosen[0] if len(chosen) == 1 else "all at once"
            yield f"{label} {'+' if up else '-'}20 %", AlongSettings.model_validate(plain)


def _numbers(plain: dict[str, Any], path: str = "") -> Iterator[str]:
    """Yield the dotted names of what is a number or a tuple of numbers."""
    for name, value in plain.items():
        if isinstance(value, dict):
            yield from _numbers(value, f"{path}{name}.")
        elif value and not isinstance(value, bool):
            yield path + name


def _move(plain: dict[str, Any], name: str, up: bool) -> None:
    *path, last = name.split(".")
    for part in path:
        plain = plain[part]
    value = plain[last]
    many = [_moved(one, last, up) for one in value] if isinstance(value, list | tuple) else None
    plain[last] = many if many is not None else _moved(value, last, up)


def _moved(value: float, name: str, up: bool) -> float:
    """Return a number 20 % larger or smaller; of a probability near 1, what is missing to 1 is moved."""
    factor = 1 + BY if up else 1 - BY
    if name == "probability":
        return 1 - (1 - value) * factor
    if isinstance(value, int):
        return max(1, value + max(1, round(BY * value)) * (1 if up else -1))
    return value * factor


def worst(rows: Sequence[RecordingRow]) -> list[tuple[str, int, RecordingRow, RecordingRow]]:
    """Return group, number of rows, and the rows of the least and of the largest SE(2) ATE in it."""
    groups: dict[str, list[RecordingRow]] = {}
    for row in rows:
        groups.setdefault(row.group, []).append(row)
    ordered = {name: sorted(own, key=lambda row: row.se2_m or 0.0) for name, own in groups.items()}
    return [(name, len(own), own[0], own[-1]) for name, own in ordered.items()]


def to_json(rows: Sequence[RecordingRow]) -> str:
    """Return the rows as JSON."""
    return json.dumps([asdict(row) for row in rows], indent=1, allow_nan=False) + "\n"


def to_csv(rows: Sequence[RecordingRow]) -> str:
    """Return the rows as CSV with a header."""
    return rows_csv(rows, RecordingRow)
