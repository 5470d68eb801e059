"""A recorded drive of panoramas mapped with odometry made from its positions: draws, scales, fewer frames, claims."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

from topomap.core.records import Estimate
from topomap.core.run_data import RunData
from topomap.evaluation.closures import accepted, count
from topomap.evaluation.rows import rows_csv
from topomap.evaluation.trajectory import ate


@dataclass(frozen=True, slots=True)
class DriveVariation:
    """One way to drive: the world so many times larger, every so many-th frame, the seed of the odometry's errors, and
    what the odometer declares as a multiple of its true variances.
    """

    scale: float = 1.0
    every: int = 1
    draw: int = 0
    declared: float = 1.0


@dataclass(frozen=True, slots=True)
class DriveRow:
    """What came of a variation: ATE SE(2) [m]; closures accepted, false, possible and recalled; the distance and the
    rotation scale found with sigmas and true (None: unobserved); which map was kept.

    false_ever: with those taken back later; farthest_m: true way between the two places of the accepted closure that
    joins the farthest.
    """

    scale: float
    every: int
    draw: int
    declared: float
    dead_reckoning_m: float | None
    map_m: float | None
    online_m: float | None
    accepted: int
    false: int | None
    false_ever: int | None
    farthest_m: float | None
    possible: int | None
    recall: float | None
    distance_scale: float | None
    distance_sigma: float
    true_distance_scale: float | None
    rotation_scale: float | None
    rotation_sigma: float
    true_rotation_scale: float | None
    kept: str
    seconds: float


def drive_row(v: DriveVariation, run: RunData, seconds: float) -> DriveRow:
    """Return what the truth says of a mapped drive."""
    found, truth, calibration = count(run), run.truth, run.calibration
    apart = [closure.judgement.distance for closure in accepted(run) if closure.judgement is not None]
    assert truth is not None
    assert calibration is not None
    distance, rotation = calibration.distance_scale, calibration.rotation_scale
    return DriveRow(
        v.scale, v.every, v.draw, v.declared,
        ate(run.dead_reckoning, truth), ate(run.final, truth), ate(run.online, truth),
        found.accepted, found.false, found.false_ever, max(apart, default=None), found.possible, found.recall,
        _seen(distance), distance.sigma, run.true_calibration.distance_scale,
        _seen(rotation), rotation.sigma, run.true_calibration.rotation_scale,
        run.trust.kept, seconds,
    )  # fmt: skip


def variations(
    scales: Sequence[float], every: Sequence[int], draws: int, declared: Sequence[float]
) -> list[DriveVariation]:
    """Return every combination, draw by draw."""
    return [DriveVariation(*chosen) for chosen in itertools.product(scales, every, range(draws), declared)]


def to_json(rows: Sequence[DriveRow]) -> str:
    """Return the rows as JSON."""
    return json.dumps([asdict(row) for row in rows], indent=1, allow_nan=False) + "\n"


def to_csv(rows: Sequence[DriveRow]) -> str:
    """Return the rows as CSV with a header."""
    return rows_csv(rows, DriveRow)


KEYS = 5
KEPT = ("drive", *(field.name for field in fields(DriveRow)))
"""Columns of a kept row; the first five cells tell rows apart."""


def kept_row(drive: str, row: DriveRow) -> tuple[str, ...]:
    """Return the row of a drive under KEPT, rounded as far as it is read."""
    return (drive, *("" if value is None else _rounded(value) for value in asdict(row).values()))


def _rounded(value: float | str) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _seen(estimate: Estimate) -> float | None:
    return estimate.value if estimate.observed else None
