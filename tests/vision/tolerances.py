"""What every method must reach, in one table: mean error [deg] over eight directions at 0.4 m, aligned views."""

from __future__ import annotations

METHOD: dict[str, float] = {
    "alv": 5.0,
    "alv-sift": 8.0,
    "alv-markers": 10.0,  # in a room of markers
    "acv": 5.0,
    "delv": 3.0,
    "delv-quantised": 14.0,
    "mfdid-gradient": 14.0,
    "mfdid-newton": 8.0,
    "warping-1d": 10.0,
    "warping-2d": 10.0,
    "dp-warping": 4.0,
    "min-warping": 6.0,
    "moment-centroid": 12.0,
    "moment-centroid-rgb": 15.0,
    "moment-2": 15.0,
    "moment-3": 10.0,
    "moment-pixel": 10.0,
    "moment-equal": 10.0,
    "moment-rgb": 15.0,
    "moment-hsv-threshold": 10.0,
    "moment-area": 5.0,
    "moment-area-equal": 5.0,
    "moment-area-rgb": 5.0,
    "moment-area-hsv": 8.0,
    "moment-ground": 15.0,
    "moment-ground-equal": 12.0,
    "moment-ground-rgb": 18.0,
    "moment-ground-area-equal": 12.0,
    "moment-ground-area-rgb": 15.0,
    "moment-polynomial": 12.0,
    "area-centroid": 3.0,
    "convergence-point": 10.0,
    "convergence-point-4": 10.0,
    "scan-matching": 0.3,
    "bipolar-matching": 20.0,
    "bipolar-inverse": 8.0,
    "bipolar-masks": 20.0,
    "pixel-landmarks": 16.0,
    "pixel-landmarks-range": 15.0,
    "stationary-1d": 8.0,
    "stationary-2d": 8.0,
    "dtw-wing": 5.0,
    "dtw-unifying": 5.0,
    "dtw-wing-2d": 5.0,
    "dtw-unifying-2d": 5.0,
    "dtw-joined": 5.0,
    "dtw-inhibited": 5.0,
    "dtw-swing": 6.0,
    "dtw-unmoved": 5.0,
    "epipolar": 2.0,
    "fusion": 1.0,
    "avoiding": 2.0,
    "auto": 1.0,
    "auto-fast": 0.5,
}
REFERENCES: dict[str, float] = {
    "comalv-references": 25.0,
    "mcomalv": 28.0,
    "did": 13.0,
    "did-far": 24.0,
    "masks-3": 16.0,
    "masks-3-even": 15.0,
    "masks-3-best": 16.0,
}
POLICIES: dict[str, tuple[float, int]] = {  # within [m] of the goal after so many looks, from 0.5 m
    "did-basic": (0.25, 60),
    "did-gradient-2": (0.25, 25),
    "did-gradient-4": (0.25, 35),
    "did-newton-4": (0.25, 35),
    "did-newton-8": (0.25, 60),
    "run-down": (0.3, 60),
    "run-down-grey": (0.3, 60),
    "run-down-threshold": (0.3, 60),
    "run-down-sorting": (0.3, 60),
    "run-down-rgb": (0.3, 60),
}
NO_CLAIM = {
    "alv-all",
    "alv-sum",
    "alv-laser",
    "delv-laser",
    "bipolar-alone",
    "skyline",
    "masks-3-printed",
    "delv-full",
    "comalv",
    "comalv-edges",
    "random-masks",
    "random-masks-references",
    "moment-colour-only",
}
"""Methods that don't claim homing: tested against their analytic fields (test_fields.py)."""
ON_A_PLAIN_FLOOR = {name for name in METHOD if name.startswith("moment-ground")} | {
    "moment-polynomial",
    "pixel-landmarks",
}
"""The ground line of a patterned floor is a line of the pattern."""
METRIC = {"delv": 0.1, "delv-quantised": 0.6, "area-centroid": 0.1, "scan-matching": 0.02, "avoiding": 0.02, "auto": 0.1, "auto-fast": 0.1}
"""Methods that give a distance, and its relative error in the mean."""
ALIGNER: dict[str, tuple[float, float]] = {  # mean error [deg] at 0.1 m and at 0.5 m, any rotation
    "visual-compass": (3.0, 12.0),
    "visual-compass-sad": (3.0, 12.0),
    "scale-plane": (3.0, 12.0),
    "phase-correlation": (3.0, 15.0),
    "phase-correlation-sum": (3.0, 30.0),
    "phase-scale": (3.0, 15.0),
    "rearrangement": (2.0, 2.0),
    "min-warping": (3.0, 2.0),
    "min-warping-near-compass": (3.0, 2.0),
    "given": (1e-6, 1e-6),
    "convergence-points": (3.0, 6.0),
    "epipolar": (1.0, 1.0),
    "auto": (1.0, 1.0),
    "auto-fast": (1.0, 1.0),
    "scan-compass": (0.3, 0.3),
}
EXACT_AT_HOME = 1e-6
BLIND = 0.35
"""The most confidence a method that looks may have in unrelated noise, where it says anything calibrated at all."""
