"""Aligners: how the current view is turned against the goal view, one file per method."""

from topomap.contract import Aligner
from topomap.vision.alignment.convergence_points import ConvergencePoints
from topomap.vision.alignment.epipolar import EpipolarCompass
from topomap.vision.alignment.given import GivenHeading
from topomap.vision.alignment.min_warping import MinWarpingCompass
from topomap.vision.alignment.phase_correlation import PhaseCorrelation
from topomap.vision.alignment.rearrangement import Rearrangement
from topomap.vision.alignment.scale_plane import ScalePlaneCompass
from topomap.vision.alignment.visual_compass import VisualCompass

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
