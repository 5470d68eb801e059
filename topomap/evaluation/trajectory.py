"""How far a trajectory lies from the truth: alignment, absolute and relative error, drift.

Steps whose true position is NaN don't count anywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2, between, compose
from topomap.core.run_data import RunData


@dataclass(frozen=True, slots=True)
class Similarity:
    """`truth_from_estimate`: scale, then rotation [rad], then translation x, y [m]."""

    scale: float
    rotation: float
    x: float
    y: float

    def apply(self, points: FloatArray) -> FloatArray:
        """Return points (N, 2) [m] in the truth's frame."""
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        moved: FloatArray = self.scale * points @ np.array([[c, s], [-s, c]]) + np.array([self.x, self.y])
        return moved

    def move(self, poses: FloatArray) -> FloatArray:
        """Return poses (N, 3) in the truth's frame."""
        turned = compose(np.array([0.0, 0.0, self.rotation]), poses)
        return np.column_stack([self.apply(poses[:, :2]), turned[:, 2]])


@dataclass(frozen=True, slots=True)
class RelativeError:
    """Error over stretches of one length: translation [m] and rotation [rad], both rms, over `stretches` of
    them."""

    translation: float
    rotation: float
    stretches: int


def travel(poses: FloatArray) -> FloatArray:
    """Return the path length [m] up to each of poses (N, 2+); a step without a position adds nothing."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(np.nan_to_num(steps))])[: len(poses)]


def step_at(stamps_ns: IntArray, stamp_ns: int) -> int:
    """Return the index of the step nearest to a stamp; the earlier one when two are equally near."""
    after = min(int(np.searchsorted(stamps_ns, stamp_ns)), len(stamps_ns) - 1)
    before = max(after - 1, 0)
    nearer = abs(stamp_ns - int(stamps_ns[before])) <= abs(int(stamps_ns[after]) - stamp_ns)
    return before if nearer else after


def true_pose(run: RunData, stamp_ns: int) -> FloatArray:
    """Return the true pose (3,) at the step nearest to a stamp, or of the older node of that stamp; NaN if unknown."""
    unknown = np.full(3, math.nan)
    if stamp_ns in run.earlier:
        return run.earlier[stamp_ns]
    if run.truth is None or not len(run.truth) or stamp_ns < run.stamps_ns[0]:
        return unknown
    pose: FloatArray = run.truth[step_at(run.stamps_ns, stamp_ns)]
    return pose


def align(estimate: FloatArray, truth: FloatArray, scale: bool = False) -> Similarity:
    """Return the least-squares similarity of estimate (N, 2) onto truth (N, 2), with scale 1 unless asked.

    Source: Umeyama, TPAMI 13(4), 1991, eq. 40-43, in the plane, where points are complex numbers and the best
    rotation is the phase of their correlation. Points that don't move get rotation 0 and scale 1.
    """
    e_mean, t_mean = estimate.mean(axis=0), truth.mean(axis=0)
    e = (estimate - e_mean) @ np.array([1, 1j])
    t = (truth - t_mean) @ np.array([1, 1j])
    correlation = complex(np.vdot(e, t))
    spread = float(np.vdot(e, e).real)
    factor = abs(correlation) / spread if scale and spread > 0.0 and correlation != 0 else 1.0
    rotation = math.atan2(correlation.imag, correlation.real)
    centre = Similarity(factor, rotation, 0.0, 0.0).apply(e_mean[None])[0]
    return Similarity(factor, rotation, float(t_mean[0] - centre[0]), float(t_mean[1] - centre[1]))


def ate(estimate: FloatArray, truth: FloatArray, scale: bool = False) -> float:
    """Return the absolute trajectory error [m]: rms over every step of poses (N, 2+), after SE(2) alignment,
    or Sim(2) with `scale`; NaN without a single known true position."""
    known = np.isfinite(truth[:, :2]).all(axis=1)
    if not known.any():
        return math.nan
    e, t = estimate[known, :2], truth[known, :2]
    gaps = align(e, t, scale).apply(e) - t
    return float(np.sqrt((gaps**2).sum(axis=1).mean()))


def rpe(estimate: FloatArray, truth: FloatArray, stretch_m: float) -> RelativeError | None:
    """Return the relative pose error of poses (N, 3) over stretches of true travel [m]; None without a
    stretch.

    Every step begins a stretch that ends at the first step at least `stretch_m` further on; the error is
    `true_end_from_estimated_end`, so true headings are needed at both ends.
    """
    path = travel(truth)
    start = np.arange(len(truth))
    end = np.searchsorted(path, path + stretch_m - 1e-9)
    start, end = start[end < len(truth)], end[end < len(truth)]
    usable = np.isfinite(truth[start]).all(axis=1) & np.isfinite(truth[end]).all(axis=1)
    start, end = start[usable], end[usable]
    if not len(start):
        return None
    error = between(between(truth[start], truth[end]), between(estimate[start], estimate[end]))
    translation = float(np.sqrt((error[:, :2] ** 2).sum(axis=1).mean()))
    return RelativeError(translation, float(np.sqrt((error[:, 2] ** 2).mean())), len(start))


def drift_percent(estimate: FloatArray, truth: FloatArray, stretch_m: float = 10.0) -> float | None:
    """Return the translation RPE over stretches as a share of their length [%]; None where RPE is."""
    error = rpe(estimate, truth, stretch_m)
    return None if error is None else 100.0 * error.translation / stretch_m


def placed(run: RunData, poses: FloatArray) -> tuple[FloatArray, str]:
    """Return poses (N, 3) of the map's frame in the truth's frame, and in words how they were aligned.

    At the start pose where its true heading is known, so that drift shows as it grew; otherwise by the SE(2)
    best fit of the final map's trajectory (a start heading guessed from a few points would swing the far
    end); without truth they stay where they are.
    """
    if run.truth is None or not len(run.truth):
        return poses, "map frame"
    if np.isfinite(run.truth[0]).all():
        origin = Pose2.of(run.truth[0]) @ Pose2.of(run.final[0]).inverse()
        return compose(origin.array(), poses), "aligned at the start pose"
    known = np.isfinite(run.truth[:, :2]).all(axis=1)
    if not known.any():
        return poses, "map frame"
    fit = align(run.final[known, :2], run.truth[known, :2])
    return fit.move(poses), "aligned by SE(2) best fit of the map"


def truth_in_map(run: RunData) -> tuple[FloatArray, str]:
    """Return the true poses (N, 3) in the map's frame, and in words how they were moved there.

    `placed` the other way round: by the first pose where its true heading is known, otherwise by the SE(2) best fit
    onto the final map. Raises TopomapError for a run without truth.
    """
    if run.truth is None or not len(run.truth):
        raise TopomapError("the run has no true poses")
    if np.isfinite(run.truth[0]).all():
        origin = Pose2.of(run.final[0]) @ Pose2.of(run.truth[0]).inverse()
        return compose(origin.array(), run.truth), "aligned at the start pose"
    known = np.isfinite(run.truth[:, :2]).all(axis=1)
    if not known.any():
        return run.truth, "nowhere known"
    fit = align(run.truth[known, :2], run.final[known, :2])
    return fit.move(run.truth), "aligned by SE(2) best fit onto the map"


def position_errors(run: RunData, poses: FloatArray) -> FloatArray | None:
    """Return the distance [m] (N,) of `placed` poses (N, 3) from the truth; None without truth."""
    if run.truth is None:
        return None
    there, _ = placed(run, poses)
    gaps: FloatArray = np.hypot(*(there[:, :2] - run.truth[:, :2]).T)
    return gaps
