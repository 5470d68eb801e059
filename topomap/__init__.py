"""topomap: loop-closing navigation with topological snapshot maps."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

from topomap.core.caches import see_to_caches

if TYPE_CHECKING:
    from topomap.app.config import RunConfig, load_config
    from topomap.app.drive import drive, replay
    from topomap.app.recordings import map_folder
    from topomap.app.runs import RunResult
    from topomap.app.wiring import build_navigator
    from topomap.core.errors import RobotFault, TopomapError
    from topomap.core.geometry import Pose2
    from topomap.core.panorama import Panorama
    from topomap.core.recorded import RecordedReading as Reading
    from topomap.core.recorded import RecordedRig as Rig
    from topomap.core.records import Alignment, Command, HomeVector, Motion
    from topomap.core.robot import Robot
    from topomap.core.run_data import RunData
    from topomap.datasets.g2o import read_graph
    from topomap.mapping.closures.closure_tests import TESTS, ClosureTest
    from topomap.mapping.graph import TopoMap
    from topomap.mapping.graph_engine import optimise_graph
    from topomap.mapping.mapfile import load_map, save_map
    from topomap.mapping.mapper import Mapper
    from topomap.navigation.navigator import Navigator
    from topomap.navigation.robot_check import Finding, check_robot
    from topomap.recording.run_reader import load_run
    from topomap.vision.compass import ALIGNERS
    from topomap.vision.home import home, load_panorama
    from topomap.vision.homing import METHODS

__version__ = version("topomap")
see_to_caches()

_LAZY = {
    "ALIGNERS": "topomap.vision.compass:ALIGNERS",
    "Alignment": "topomap.core.records:Alignment",
    "ClosureTest": "topomap.mapping.closures.closure_tests:ClosureTest",
    "Command": "topomap.core.records:Command",
    "Finding": "topomap.navigation.robot_check:Finding",
    "HomeVector": "topomap.core.records:HomeVector",
    "METHODS": "topomap.vision.homing:METHODS",
    "Mapper": "topomap.mapping.mapper:Mapper",
    "Motion": "topomap.core.records:Motion",
    "Navigator": "topomap.navigation.navigator:Navigator",
    "Panorama": "topomap.core.panorama:Panorama",
    "Pose2": "topomap.core.geometry:Pose2",
    "Reading": "topomap.core.recorded:RecordedReading",
    "Rig": "topomap.core.recorded:RecordedRig",
    "Robot": "topomap.core.robot:Robot",
    "RobotFault": "topomap.core.errors:RobotFault",
    "RunConfig": "topomap.app.config:RunConfig",
    "RunData": "topomap.core.run_data:RunData",
    "RunResult": "topomap.app.runs:RunResult",
    "TESTS": "topomap.mapping.closures.closure_tests:TESTS",
    "TopoMap": "topomap.mapping.graph:TopoMap",
    "TopomapError": "topomap.core.errors:TopomapError",
    "build_navigator": "topomap.app.wiring:build_navigator",
    "check_robot": "topomap.navigation.robot_check:check_robot",
    "drive": "topomap.app.drive:drive",
    "home": "topomap.vision.home:home",
    "load_config": "topomap.app.config:load_config",
    "load_map": "topomap.mapping.mapfile:load_map",
    "load_panorama": "topomap.vision.home:load_panorama",
    "load_run": "topomap.recording.run_reader:load_run",
    "map_folder": "topomap.app.recordings:map_folder",
    "optimise_graph": "topomap.mapping.graph_engine:optimise_graph",
    "read_graph": "topomap.datasets.g2o:read_graph",
    "replay": "topomap.app.drive:replay",
    "save_map": "topomap.mapping.mapfile:save_map",
}
__all__ = [
    "ALIGNERS", "METHODS", "TESTS", "Alignment", "ClosureTest", "Command", "Finding", "HomeVector", "Mapper", "Motion",
    "Navigator", "Panorama", "Pose2", "Reading", "Rig", "Robot", "RobotFault", "RunConfig", "RunData", "RunResult",
    "TopoMap", "TopomapError", "__version__", "build_navigator", "check_robot", "drive", "home", "load_config",
    "load_map", "load_panorama", "load_run", "map_folder", "optimise_graph", "read_graph", "replay", "save_map",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """Import a name of the face when it is first asked for: `import topomap` alone stays light."""
    if name not in _LAZY:
        raise AttributeError(f"module 'topomap' has no attribute {name!r}; it offers {', '.join(__all__)}")
    module, _, thing = _LAZY[name].partition(":")
    return getattr(import_module(module), thing)


def __dir__() -> list[str]:
    return __all__
