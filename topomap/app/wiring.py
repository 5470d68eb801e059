"""The composition root: worlds, logs and the stack put together."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import version

from topomap.app.config import StackConfig
from topomap.mapping.closures.closure_tests import ClosureTest
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser import Localiser
from topomap.navigation.manoeuvres.active_check import ActiveCheck
from topomap.navigation.manoeuvres.relocalise import Relocalise
from topomap.navigation.mission import Mission
from topomap.navigation.navigator import Navigator
from topomap.navigation.pilot import Pilot
from topomap.navigation.traveller import Traveller
from topomap.vision.registry import aligned_homing, aligner

PACKAGES = ("topomap", "numpy", "scipy", "numba", "opencv-python-headless", "gtsam", "networkx", "pymunk", "mcap")


def build_navigator(config: StackConfig, tests: Sequence[ClosureTest] = ()) -> Navigator:
    """Return a fresh stack with the methods that the settings name. Raises DataError.

    tests: of closures, a user's own, asked before odometry is.
    """
    travel = config.travel
    homing = aligned_homing(travel.homing, travel.aligner)
    mapper = Mapper(config.mapper, aligner(config.mapper.aligner), tests)
    active = ActiveCheck(config.active, Pilot(travel.pilot), homing)
    relocalise = Relocalise(Pilot(travel.pilot))
    return Navigator(mapper, Localiser(), Mission(config.mission), Traveller(travel, homing), active, relocalise)


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that decide a run's result."""
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
