"""Recordings in the format of the TUC SLAM data set (Neubert, Schubert, Protzel, RA-L 2019)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.geometry import wrap_all
from topomap.mapping.odometry.increments import Increments

Rows = dict[str, list[list[float]]]

ODOMETRY = ("time", "velocity x", "velocity y", "turn rate", "variance x", "variance y", "variance turn rate")
LOOP = ("time of the query", "time of the match", "similarity")
POINT = ("time", "x", "y", "cov xx", "cov xy", "cov yx", "cov yy")
LARGEST_TIME = 9e9  # [s] a stamp holds hardly more nanoseconds
ANGLE = ("time", "heading", "variance")


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """True positions xy (T, 2) [m] at stamps_ns (T,), headings (T,) [rad], NaN where the file has none."""

    stamps_ns: IntArray
    xy: FloatArray
    headings: FloatArray

    def at(self, stamps_ns: IntArray) -> FloatArray:
        """Return (N, 3) x, y, heading interpolated at stamps [ns]."""
        x, y = (np.interp(stamps_ns, self.stamps_ns, self.xy[:, k]) for k in (0, 1))
        heading = np.interp(stamps_ns, self.stamps_ns, np.unwrap(self.headings))
        return np.column_stack([x, y, wrap_all(heading)])


@dataclass(frozen=True, slots=True, eq=False)
class TucRecording:
    """Odometry and loop candidates of one drive.

    stamps_ns (K,); velocities (K, 3): forward, left [m/s], turn rate [rad/s]; variances (K, 3) of these; query_ns,
    match_ns, similarity (M,): loop candidates in file order; truth: None where there is no file for it.
    """

    name: str
    stamps_ns: IntArray
    velocities: FloatArray
    variances: FloatArray
    query_ns: IntArray
    match_ns: IntArray
    similarity: FloatArray
    truth: Truth | None

    def increments(self, extra_ns: IntArray) -> Increments:
        """Return the raw increments with ends at all odometry stamps after the first and at extra stamps (E,).

        A row's velocity holds until the next row. An odometer that reads nothing at all is taken to stand.
        """
        inside = extra_ns[(extra_ns > self.stamps_ns[0]) & (extra_ns < self.stamps_ns[-1])]
        stamps = np.union1d(self.stamps_ns, inside)
        row = np.searchsorted(self.stamps_ns, stamps[:-1], side="right") - 1
        dt = (np.diff(stamps) / 1e9)[:, None]
        moving = np.any(self.velocities[row], axis=1, keepdims=True)
        variances = self.variances[row] * (dt * _row_seconds(self.stamps_ns)[row][:, None]) * moving
        covariances = variances[:, :, None] * np.eye(3)
        return Increments(stamps[1:], self.velocities[row] * dt, covariances)


def read_tuc(path: Path) -> TucRecording:
    """Read a recording from its folder or its `*_Input.txt`; the truth `*_GT.txt` beside it may be missing.

    Raises DataError that names file, line and field.
    """
    source = _input_file(path)
    rows = _rows(source, {"odom2": ODOMETRY, "loop": LOOP})
    odometry = _array(rows["odom2"], len(ODOMETRY))
    if len(odometry) < 2:
        raise DataError(f"{source}: a recording needs at least two rows 'odom2', it has {len(odometry)}")
    _check(source, odometry)
    # a candidate that is written twice was still seen once
    loops = _array([list(row) for row in dict.fromkeys(map(tuple, rows["loop"]))], len(LOOP))
    truth = source.with_name(source.name.replace("_Input", "_GT"))
    return TucRecording(
        source.name.removesuffix("_Input.txt"),
        _ns(odometry[:, 0]),
        odometry[:, 1:4],
        odometry[:, 4:7],
        _ns(loops[:, 0]),
        _ns(loops[:, 1]),
        loops[:, 2],
        _read_truth(truth) if truth.exists() and truth != source else None,
    )


def _input_file(path: Path) -> Path:
    if path.is_file():
        return path
    found = sorted(path.glob("*_Input.txt")) if path.is_dir() else []
    if len(found) != 1:
        what = "no such folder or file" if not path.exists() else f"{len(found)} files '*_Input.txt' where one is due"
        raise DataError(f"{path}: {what}")
    return found[0]


def _read_truth(path: Path) -> Truth:
    rows = _rows(path, {"point2": POINT, "angle": ANGLE})
    points, angles = _array(rows["point2"], len(POINT)), _array(rows["angle"], len(ANGLE))
    if len(points) == 0:
        raise DataError(f"{path}: no row 'point2'")
    _increasing(path, "point2", points[:, 0])
    headings = np.full(len(points), np.nan)
    if len(angles):
        _increasing(path, "angle", angles[:, 0])
        headings = wrap_all(np.interp(points[:, 0], angles[:, 0], np.unwrap(angles[:, 1])))
    return Truth(_ns(points[:, 0]), points[:, 1:3], headings)


def _rows(path: Path, kinds: dict[str, tuple[str, ...]]) -> Rows:
    """Return the numbers of every row by its name."""
    rows: Rows = {kind: [] for kind in kinds}
    try:
        lines = regular(path).read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words:
            continue
        if words[0] not in kinds:
            raise DataError(f"{path}:{number}: row '{words[0]}' is none of {', '.join(kinds)}")
        rows[words[0]].append(_numbers(f"{path}:{number}", words, kinds[words[0]]))
    return rows


def _numbers(where: str, words: list[str], fields: tuple[str, ...]) -> list[float]:
    if len(words) != len(fields) + 1:
        raise DataError(
            f"{where}: '{words[0]}' needs {len(fields)} numbers ({', '.join(fields)}), has {len(words) - 1}"
        )
    return [_number(where, field, word) for field, word in zip(fields, words[1:], strict=True)]


def _number(where: str, field: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise DataError(f"{where}: {field}: '{word}' is no number") from None
    if not math.isfinite(value):
        raise DataError(f"{where}: {field}: '{word}' isn't finite")
    if field.startswith("time") and abs(value) > LARGEST_TIME:
        raise DataError(f"{where}: {field}: '{word}' s is no time")
    return value


def _check(path: Path, odometry: FloatArray) -> None:
    _increasing(path, "odom2", odometry[:, 0])
    negative = np.flatnonzero((odometry[:, 4:] < 0).any(axis=1))
    if len(negative):
        raise DataError(f"{path}: row {negative[0] + 1} of 'odom2': a variance is negative")


def _increasing(path: Path, kind: str, times: FloatArray) -> None:
    back = np.flatnonzero(np.diff(times) < 0)
    if len(back):
        raise DataError(f"{path}: row {back[0] + 2} of '{kind}': time: {times[back[0] + 1]:g} s runs backwards")


def _array(rows: list[list[float]], columns: int) -> FloatArray:
    return np.array(rows, float).reshape(-1, columns)


def _ns(seconds: FloatArray) -> IntArray:
    return np.asarray(np.round(seconds * 1e9), dtype=np.int64)


def _row_seconds(stamps_ns: IntArray) -> FloatArray:
    """Return (K,) how long each row holds [s]: its noise is one draw for all that time."""
    return np.append(np.diff(stamps_ns), 0) / 1e9
