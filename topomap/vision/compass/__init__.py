"""Aligners: how the current view is turned against the goal view, one file per method."""

import math

from topomap.vision.compass.convergence_points import ConvergencePoints
from topomap.vision.compass.epipolar_compass import EpipolarCompass
from topomap.vision.compass.given import GivenHeading
from topomap.vision.compass.min_warping_compass import MinWarpingCompass
from topomap.vision.compass.phase_correlation import PhaseCorrelation
from topomap.vision.compass.rearrangement import Rearrangement
from topomap.vision.compass.scale_plane_compass import ScalePlaneCompass
from topomap.vision.compass.visual_compass import VisualCompass
from topomap.vision.contracts import Aligner
from topomap.vision.homing.auto import Auto
from topomap.vision.homing.scan import ScanMatching

ALIGNERS: dict[str, Aligner] = {
    "visual-compass": VisualCompass(),
    "visual-compass-sad": VisualCompass(form="sad"),
    "scale-plane": ScalePlaneCompass(),
    "phase-correlation": PhaseCorrelation(),
    "phase-correlation-sum": PhaseCorrelation("sum"),
    "phase-scale": PhaseCorrelation(levels=4),
    "rearrangement": Rearrangement(),
    "min-warping": MinWarpingCompass(),
    "min-warping-near-compass": MinWarpingCompass(search="compass"),
    "given": GivenHeading(),
    "convergence-points": ConvergencePoints(),
    "epipolar": EpipolarCompass(),
    "auto": Auto(),
    "auto-fast": Auto(keypoints=False),
    "scan-compass": ScanMatching(window=math.pi),
}

__all__ = [
    "ALIGNERS",
    "ConvergencePoints",
    "EpipolarCompass",
    "GivenHeading",
    "MinWarpingCompass",
    "PhaseCorrelation",
    "Rearrangement",
    "ScalePlaneCompass",
    "VisualCompass",
]
