"""Studies on conditions that changed since the goal was seen: hour of the day, tilt, exposure (5.44, 5.45)."""

from __future__ import annotations

from collections.abc import Sequence

from topomap.bench.homing.contestant import contestant
from topomap.experiments.study import Finding, Lab, curves_finding, error_curve

ROOM = "a1original"
METHODS = ("dtw-unifying", "min-warping", "stationary-1d", "acv", "did")


def daylight(lab: Lab) -> Finding:
    """The goal was seen at 14:00; the robot comes back at another hour (5.44, 5.45)."""
    hours = (6.0, 10.0, 14.0, 20.0, 24.0)
    found = _over(lab, hours, [(f"hour={hour:g}", "goal:hour=14") for hour in hours], "Hour of the day", "hour")
    found.figure.axes[0].axvline(14.0, color="#C4C4C4", linewidth=1.0, zorder=1)
    found.figure.axes[0].set_xticks(hours)
    return found


def tilt(lab: Lab) -> Finding:
    """The robot leans to the right; the goal was seen upright."""
    degrees = (0.0, 1.0, 2.0, 4.0, 8.0)
    return _over(lab, degrees, [(f"roll_deg={d:g}",) for d in degrees], "Tilt of the camera", "roll [deg]")


def gain(lab: Lab) -> Finding:
    """The robot's camera is brighter or darker than when the goal was seen."""
    gains = (0.5, 0.7, 1.0, 1.4, 2.0)
    return _over(lab, gains, [(f"gain={g:g}",) for g in gains], "Exposure gain", "gain")


def _over(lab: Lab, x: Sequence[float], options: Sequence[tuple[str, ...]], title: str, label: str) -> Finding:
    several = [contestant(name) for name in METHODS]
    rows = [lab.rows(ROOM, several, one) for one in options]
    curves = [error_curve(name, x, [row[name] for row in rows]) for name in METHODS]
    return curves_finding(f"{title}, {ROOM}", label, "mean angular error [deg]", curves)
