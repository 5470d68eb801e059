"""Homing methods: where the goal lies, seen from here, one file per family."""

from dataclasses import replace
from typing import Any

from topomap.vision.contracts import GoalView, HomingMethod, HomingPolicy, Needs, Origin, ReferenceHoming
from topomap.vision.homing.acv import AverageCorrectionalVector
from topomap.vision.homing.alv import AverageLandmarkVector
from topomap.vision.homing.area_centroid import AreaCentroid
from topomap.vision.homing.auto import Auto
from topomap.vision.homing.avoiding import Avoiding
from topomap.vision.homing.bipolar import BipolarMasks
from topomap.vision.homing.comalv import CentreOfMass, ModifiedCentreOfMass, ReferenceJacobian
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.delv import DistanceLandmarkVector
from topomap.vision.homing.did import WHOLE, ImageDescent
from topomap.vision.homing.did_moves import TrialMoves
from topomap.vision.homing.dp_warping import DpWarping
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.epipolar import Epipolar
from topomap.vision.homing.equal_warping import EqualWarping, RingWarping
from topomap.vision.homing.fusion import Fusion
from topomap.vision.homing.matched_filter import MatchedFilterDescent
from topomap.vision.homing.min_warping import MinWarping
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.pixel_landmarks import PixelLandmarks
from topomap.vision.homing.random_masks import RandomMasks, ReferenceMasks
from topomap.vision.homing.run_down import RunDown
from topomap.vision.homing.scan import ScanMatching
from topomap.vision.homing.skyline import SkylineHoming
from topomap.vision.homing.stationary_points import StationaryImage, StationaryPoints
from topomap.vision.image.haar_masks import WIDE, MaskSpec
from topomap.vision.image.keypoints import KeypointSpec
from topomap.vision.image.landmarks import MarkerSpec
from topomap.vision.image.laser_landmarks import JumpSpec

METHODS: dict[str, HomingMethod[Any]] = {  # Any: each method keeps its own kind of description
    "alv": AverageLandmarkVector(),
    "alv-all": AverageLandmarkVector(pairing="all"),
    "alv-sum": AverageLandmarkVector(pairing="sum"),
    "alv-sift": AverageLandmarkVector(recipe=KeypointSpec()),
    "alv-laser": AverageLandmarkVector(recipe=JumpSpec()),
    "alv-markers": AverageLandmarkVector(recipe=MarkerSpec(), pairing="all"),
    "acv": AverageCorrectionalVector(),
    "delv": DistanceLandmarkVector(),
    "delv-full": DistanceLandmarkVector(pairing="full"),
    "delv-quantised": DistanceLandmarkVector(levels=4),
    "delv-laser": DistanceLandmarkVector(recipe=JumpSpec()),
    "comalv": CentreOfMass(),
    "comalv-edges": CentreOfMass(edges=True),
    "mfdid-gradient": MatchedFilterDescent("gradient"),
    "mfdid-newton": MatchedFilterDescent("newton"),
    "warping-1d": RingWarping(),
    "warping-2d": EqualWarping(),
    "dp-warping": DpWarping(),
    "min-warping": MinWarping(),
    "moment-centroid": Moment(form="centroid", feature="equal"),
    "moment-centroid-rgb": Moment(form="centroid", feature="rgb"),
    "moment-2": Moment(2.0),
    "moment-3": Moment(3.0),
    "moment-pixel": Moment(2.0, form="pixel"),
    "moment-equal": Moment(2.0, "equal"),
    "moment-rgb": Moment(2.0, "rgb"),
    "moment-hsv-threshold": Moment(2.0, "hsv-threshold"),
    "moment-area": Moment(2.0, form="area"),
    "moment-area-equal": Moment(2.0, "equal", "area"),
    "moment-area-rgb": Moment(2.0, "rgb", "area"),
    "moment-area-hsv": Moment(2.0, "hsv", "area"),
    "moment-ground": Moment(2.0, form="area", distance="ground"),
    "moment-ground-equal": Moment(2.0, "equal", distance="ground"),
    "moment-ground-rgb": Moment(2.0, "rgb", distance="ground"),
    "moment-ground-area-equal": Moment(2.0, "equal", "area", "ground"),
    "moment-ground-area-rgb": Moment(2.0, "rgb", "area", "ground"),
    "moment-polynomial": Moment(2.0, "equal", "area", "polynomial"),
    "moment-colour-only": Moment(2.0, "rgb", distance="equal"),
    "area-centroid": AreaCentroid(),
    "convergence-point": ConvergencePoint(),
    "convergence-point-4": ConvergencePoint(4.0),
    "scan-matching": ScanMatching(),
    "bipolar-alone": BipolarMasks(stage="masks"),
    "bipolar-matching": BipolarMasks(stage="matching", score="inverse"),
    "bipolar-inverse": BipolarMasks(score="inverse"),
    "bipolar-masks": BipolarMasks(),
    "random-masks": RandomMasks(),
    "pixel-landmarks": PixelLandmarks(),
    "pixel-landmarks-range": PixelLandmarks(distance="range"),
    "stationary-1d": StationaryPoints(),
    "stationary-2d": StationaryImage(),
    "dtw-wing": DynamicWarping(wings="wing"),
    "dtw-unifying": DynamicWarping(),
    "dtw-wing-2d": DynamicWarping(wings="wing", start="image"),
    "dtw-unifying-2d": DynamicWarping(start="image"),
    "dtw-joined": DynamicWarping(wings="joined"),
    "dtw-inhibited": DynamicWarping(inhibition="target"),
    "dtw-swing": DynamicWarping(swing=0.2618),
    "dtw-unmoved": DynamicWarping(unmoved=True),
    "skyline": SkylineHoming(),
    "epipolar": Epipolar(),
    "fusion": Fusion(),
    "avoiding": Avoiding(),
    "auto": Auto(),
    "auto-fast": Auto(keypoints=False),
}
"""Pure functions of two described panoramas."""

REFERENCE_METHODS: dict[str, ReferenceHoming] = {
    "comalv-references": ReferenceJacobian(CentreOfMass()),
    "mcomalv": ModifiedCentreOfMass(),
    "did": ImageDescent(),
    "did-far": ImageDescent(step=0.3),
    "did-whole": ImageDescent(WHOLE),
    "random-masks-references": ReferenceJacobian(RandomMasks(), step=0.3),
    "masks-3": ReferenceMasks(),
    "masks-3-printed": ReferenceMasks(MaskSpec()),
    "masks-3-even": ReferenceMasks(replace(WIDE, even=True)),
    "masks-3-best": ReferenceMasks(replace(WIDE, count=4000, even=True, candidates=4)),
}
"""Methods that are given references taken around the goal."""

POLICIES: dict[str, HomingPolicy[Any]] = {  # Any: each policy has its own state
    "did-basic": TrialMoves("basic", 8),
    "did-gradient-2": TrialMoves("gradient", 2),
    "did-gradient-4": TrialMoves("gradient", 4),
    "did-newton-4": TrialMoves("newton", 4),
    "did-newton-8": TrialMoves("newton", 8),
    "run-down": RunDown(),
    "run-down-grey": RunDown("all"),
    "run-down-threshold": RunDown("threshold"),
    "run-down-sorting": RunDown("sorting"),
    "run-down-rgb": RunDown("sorting", colour=True),
}
"""Methods that act and look."""

__all__ = [
    "METHODS",
    "POLICIES",
    "REFERENCE_METHODS",
    "AreaCentroid",
    "Auto",
    "DynamicWarping",
    "Epipolar",
    "GoalView",
    "HomingPolicy",
    "MinWarping",
    "Moment",
    "Needs",
    "Origin",
    "ReferenceHoming",
]
