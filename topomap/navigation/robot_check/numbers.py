"""Checks of a reading's numbers: are they there, of their type, and in their units?"""

from __future__ import annotations

import math
from itertools import pairwise
from numbers import Integral, Real

import numpy as np

from topomap.core.geometry import TAU
from topomap.navigation.robot_check.finding import Finding, Findings, Readings

READING = ("stamp_ns", "image", "encoded", "ranges", "motion", "rig", "contact", "driven")
MOTION = ("forward", "left", "turn", "covariance", "dt")
RIG = ("width", "height", "horizon_row", "focal", "camera_height", "forward_column", "clockwise")
FAST = 10.0
"""[m/s] No robot this stack is for goes faster; a slow one that reads millimetres does."""
SPIN = 2 * TAU
"""[rad/s] nor turns faster; what reads degrees at half a radian per second is at 28."""
SHORT, LONG = 1e-3, 30.0
"""[s] between which the time of a step must lie to be trusted when stamps and dt contradict one another."""
TALL = 5.0
"""[m] Cameras on robots are lower; one of half a metre in centimetres or millimetres is higher."""


def check_fields(seen: Readings) -> Findings:
    """Find fields that are missing or of another type."""
    first = seen[0]
    missing = [name for name in READING if not hasattr(first, name)]
    if not missing:
        missing = [f"motion.{name}" for name in MOTION if not hasattr(first.motion, name)]
        missing += [f"rig.{name}" for name in RIG if not hasattr(first.rig, name)]
    found = [Finding(name, "is missing") for name in missing]
    return found or _types(seen)


def _types(seen: Readings) -> Findings:
    found = []
    flags = {name: getattr(seen[0], name) for name in ("contact", "driven")}
    for name, value in {**flags, "rig.clockwise": seen[0].rig.clockwise}.items():
        if not isinstance(value, bool | np.bool_):
            found.append(Finding(name, f"is {value!r}, it must be True or False"))
    for name in ("forward", "left", "turn", "dt"):
        wrong = next((v for r in seen if not _number(v := getattr(r.motion, name))), None)
        if wrong is not None:
            found.append(Finding(f"motion.{name}", f"is {wrong!r}, it must be a finite number"))
    return found


def _number(value: object) -> bool:
    return isinstance(value, Real) and math.isfinite(value)


def check_rig(seen: Readings) -> Findings:
    """Find a rig that is no panoramic camera's, or that changes."""
    rig = seen[0].rig
    found = []
    if not (rig.width > 0 and rig.height > 0):
        return [Finding("rig.width", f"is {rig.width} x {rig.height} pixels: both must be positive")]
    if not 0 <= rig.horizon_row < rig.height:
        found.append(Finding("rig.horizon_row", f"is {rig.horizon_row}, eye level must lie in the {rig.height} rows"))
    if not 0.5 < rig.focal / (rig.width / TAU) < 2.0:
        text = f"is {rig.focal:g} pixels; of {rig.width} columns all round it is about {rig.width / TAU:.1f}, W/(2 pi)"
        found.append(Finding("rig.focal", text))
    if not 0 < rig.camera_height < TALL:
        found.append(Finding("rig.camera_height", f"is {rig.camera_height:g}, it must be in metres above the floor"))
    if not 0 <= rig.forward_column < rig.width:
        found.append(Finding("rig.forward_column", f"is {rig.forward_column}, there are {rig.width} columns"))
    if any(getattr(reading.rig, name) != getattr(rig, name) for reading in seen for name in RIG):
        found.append(Finding("rig", "changes from reading to reading; a log holds one"))
    return found


def check_stamps(seen: Readings) -> Findings:
    """Find stamps in other units, repeated ones and ones that go backwards; dt that isn't the time between them."""
    stamps = [reading.stamp_ns for reading in seen]
    spent = 1e9 * sum(reading.motion.dt for reading in seen[1:])
    ratio = (stamps[-1] - stamps[0]) / spent if spent > 0 else math.nan
    plausible = SHORT < float(np.median([reading.motion.dt for reading in seen[1:]] or [0.0])) < LONG
    for unit, size in (("seconds", 1e-9), ("milliseconds", 1e-6), ("microseconds", 1e-3)):
        if plausible and 0.3 * size < ratio < 3 * size:
            return [Finding("stamp_ns", f"counts {unit}, it must count nanoseconds (as motion.dt tells)")]
    for one, other in pairwise(stamps):
        if not isinstance(other, Integral):
            return [Finding("stamp_ns", f"is {other!r}, it must be an int of nanoseconds")]
        if other == one:
            return [Finding("stamp_ns", f"is repeated: {other}; every reading must be later than the one before")]
        if other < one:
            return [Finding("stamp_ns", f"goes backwards: {one}, then {other}")]
    return _dt(seen, ratio)


def _dt(seen: Readings, ratio: float) -> Findings:
    if len(seen) < 2 or 0.5 < ratio < 2.0:
        return []
    dt = seen[-1].motion.dt
    return [Finding("motion.dt", f"is {dt:g}, it must be the seconds since the reading before (as stamp_ns tells)")]


def check_motion(seen: Readings) -> Findings:
    """Find ways and turns that no robot makes: other units."""
    moved = [reading.motion for reading in seen[1:]]
    seconds = _steps_s(seen)
    found = []
    for name in ("forward", "left"):
        speed = max((abs(getattr(m, name)) / s for m, s in zip(moved, seconds, strict=True)), default=0.0)
        if speed > FAST:
            text = f"says {speed:.0f} m/s: is it in millimetres or centimetres? It must be in metres since the last"
            found.append(Finding(f"motion.{name}", text))
    spin = max((abs(m.turn) / s for m, s in zip(moved, seconds, strict=True)), default=0.0)
    if spin > SPIN:
        found.append(Finding("motion.turn", f"says {spin:.0f} rad/s: is it in degrees? It must be in radians"))
    return found


def _steps_s(seen: Readings) -> list[float]:
    """Return the longest that each step can have taken [s], so that a wrong dt or stamp isn't counted as speed."""
    gaps = (abs(float(b.stamp_ns) - float(a.stamp_ns)) / 1e9 for a, b in pairwise(seen))
    return [max(gap, abs(b.motion.dt), 1e-3) for gap, b in zip(gaps, seen[1:], strict=True)]
