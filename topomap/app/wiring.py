"""The composition root: worlds, logs and the stack put together."""

from __future__ import annotations

import platform
from importlib.metadata import version

from topomap.app.config import StackConfig
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser import Localiser
from topomap.navigation.manoeuvres.active_check import ActiveCheck
from topomap.navigation.mission import Mission
from topomap.navigation.navigator import Navigator
from topomap.navigation.pilot import Pilot
from topomap.navigation.traveller import Traveller
from topomap.vision.compass.min_warping_compass import MinWarpingCompass

PACKAGES = ("topomap", "numpy", "scipy", "numba", "opencv-python-headless", "gtsam", "networkx", "pymunk", "mcap")


def build_navigator(config: StackConfig) -> Navigator:
    """Return a fresh stack with the default methods: min-warping as compass and for homing."""
    homing = MinWarpingCompass()
    mapper = Mapper(config.mapper, homing)
    active = ActiveCheck(config.active, Pilot(config.travel.pilot), homing)
    return Navigator(mapper, Localiser(), Mission(config.mission), Traveller(config.travel, homing), active)


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that decide a run's result."""
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
