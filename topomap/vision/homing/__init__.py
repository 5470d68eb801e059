"""Homing methods: where the goal lies, seen from here, one file per family."""

from typing import Any

from topomap.contract import HomingMethod
from topomap.vision.homing.area_centroid import AreaCentroid
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.min_warping import MinWarping
from topomap.vision.homing.needs import Needs, check

METHODS: dict[str, HomingMethod[Any]] = {  # Any: each method keeps its own kind of description
    "min-warping": MinWarping(),
    "dtw-wing": DynamicWarping(wings="wing"),
    "dtw-unifying": DynamicWarping(),
    "area-centroid": AreaCentroid(),
}

__all__ = ["METHODS", "AreaCentroid", "DynamicWarping", "MinWarping", "Needs", "check"]
