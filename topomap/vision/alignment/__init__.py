"""Aligners: how the current view is turned against the goal view, one file per method."""

from topomap.contract import Aligner
from topomap.vision.alignment.given import GivenHeading
from topomap.vision.alignment.min_warping import MinWarpingCompass
from topomap.vision.alignment.visual_compass import VisualCompass

ALIGNERS: dict[str, Aligner] = {
    "visual-compass": VisualCompass(),
    "visual-compass-sad": VisualCompass(form="sad"),
    "min-warping": MinWarpingCompass(),
    "min-warping-near-compass": MinWarpingCompass(search="compass"),
    "given": GivenHeading(),
}

__all__ = ["ALIGNERS", "GivenHeading", "MinWarpingCompass", "VisualCompass"]
