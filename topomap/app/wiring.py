"""The composition root: worlds, logs and the stack put together."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import version

from topomap.app.config import StackConfig
from topomap.app.saved_map import SavedMap
from topomap.mapping.closures.closure_tests import ClosureTest
from topomap.mapping.closures.robot_tests import RobotTests
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser import HERE, Localiser
from topomap.navigation.manoeuvres.active_check import ActiveCheck
from topomap.navigation.manoeuvres.hall_course import HallCourse
from topomap.navigation.manoeuvres.relocalise import Relocalise
from topomap.navigation.mission import Mission
from topomap.navigation.navigator import Navigator
from topomap.navigation.pilot import Pilot
from topomap.navigation.traveller import Traveller
from topomap.navigation.wish import Kind
from topomap.vision.registry import aligned_homing, aligner

PACKAGES = ("topomap", "numpy", "scipy", "numba", "opencv-python-headless", "gtsam", "networkx", "pymunk", "mcap")


def build_navigator(
    config: StackConfig, tests: Sequence[ClosureTest] | RobotTests = (), saved: SavedMap | None = None
) -> Navigator:
    """Return a stack with the methods that the settings name, fresh or on a saved map. Raises DataError.

    tests: of closures, a user's own, asked before odometry is, or all of them.
    """
    travel = config.travel
    homing = aligned_homing(travel.homing, travel.aligner)
    mapper = Mapper(config.mapper, aligner(config.mapper.aligner), tests, saved.drive_start if saved else None)
    localiser = Localiser(saved.start if saved else HERE)
    active = ActiveCheck(config.active, Pilot(travel.pilot), homing)
    relocalise = Relocalise(Pilot(travel.pilot))
    course = None
    if config.mission.wish.kind is Kind.HALL:
        course, mapper.explores = HallCourse(config.hall, Pilot(travel.pilot), homing), True
    return Navigator(mapper, localiser, Mission(config.mission), Traveller(travel, homing), active, relocalise, course)


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that decide a run's result."""
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
