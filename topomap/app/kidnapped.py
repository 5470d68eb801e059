"""A taught robot set down anywhere on its map, turned any way: how far it drives until it knows where."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.records import SetDown
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator
from topomap.bench.belief import is_wrong
from topomap.bench.searches import SOON, Search, curve, tally
from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Phase, Where
from topomap.mapping.graph import TopoMap
from topomap.navigation.manoeuvres.relocalise import FOUND
from topomap.navigation.navigator import Navigator
from topomap.report.figures.calibration import calibration_curve
from topomap.report.figures.style import png

ASIDE = 0.3
"""[m] How far beside the taught route the robot is set down at most."""
Pose = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Lesson:
    """A world that was taught: the navigator at the hand-over, the nodes' true poses (N, 3), the robot's then, and the
    next step.
    """

    world: str
    seed: int
    config: RunConfig
    navigator: Navigator
    truth: FloatArray
    end: Pose
    step: int


def teach(world: str, seed: int, config: RunConfig) -> Lesson:
    """Drive the world's route once; the stack is kept as it stands when the driver hands over. Raises DataError."""
    try:
        robot = SimRobot(worlds.load(world), config.sim, seed)
    except WorldError as error:
        raise DataError(str(error)) from error
    warm_up(config.stack)
    navigator = build_navigator(config.stack)
    truth: dict[int, Pose] = {}
    step = 0
    while (reading := robot.sense()) is not None and reading.driven:
        here = robot.truth()
        truth[reading.stamp_ns] = here.x, here.y, here.heading
        navigator.step(reading)
        step += 1
    nodes = np.array([truth[node.stamp_ns] for node in navigator.mapper.map.nodes])
    end = robot.truth()
    return Lesson(world, seed, config, navigator, nodes, (end.x, end.y, end.heading), step + 1)


def starts(lesson: Lesson, count: int) -> list[Pose]:
    """Return true poses spread over the taught route, up to 0.3 m beside it, turned any way."""
    rng = np.random.default_rng(np.random.SeedSequence([lesson.seed, count]))
    views = [k for k, node in enumerate(lesson.navigator.mapper.map.nodes) if node.snapshot is not None]
    found = []
    for _ in range(count):
        x, y, heading = lesson.truth[views[int(rng.integers(len(views)))]]
        aside, turn = rng.uniform(-ASIDE, ASIDE), rng.uniform(-math.pi, math.pi)
        found.append((float(x - aside * math.sin(heading)), float(y + aside * math.cos(heading)), float(turn)))
    return found


def search(lesson: Lesson, start: Pose, farthest: float = 35.0) -> Search:
    """Set the robot down and let it go home, until it says that it knows where it is or gives up."""
    navigator = copy.deepcopy(lesson.navigator)
    robot = SimRobot(worlds.load(lesson.world), lesson.config.sim, lesson.seed, SetDown(start, lesson.step))
    way, before, said, wrong, noticed = 0.0, start, list[float](), list[bool](), False
    while way < farthest and (reading := robot.sense()) is not None:
        command, record = navigator.step(reading)
        truth = robot.truth()
        here = truth.x, truth.y, truth.heading
        way, before = way + math.hypot(here[0] - before[0], here[1] - before[1]), here
        said.append(record.where.lost)
        wrong.append(_is_wrong(record.where, here, lesson.truth, navigator.mapper.map))
        # who was sure all along has not noticed: where it then is, it has to know by SOON
        noticed = noticed or bool(record.change.broken) or said[-1] >= FOUND or way >= SOON
        known = record.where.lost < FOUND and noticed and len(said) > 1
        if known or record.travel.phase in (Phase.ARRIVED, Phase.FAILED):
            return Search(known, known and not wrong[-1], way, np.array(said), np.array(wrong))
        robot.act(command)
    return Search(False, False, way, np.array(said), np.array(wrong))


def _is_wrong(where: Where, here: Pose, nodes: FloatArray, topo: TopoMap) -> bool:
    if where.node is None:
        return True
    return is_wrong(where, Pose2(*here), Pose2.of(nodes[where.node]), topo.pose(where.node))


def searches(world: str, seed: int, config: RunConfig, count: int) -> Iterator[Search]:
    """Teach the world and yield a search from each of some places. Raises DataError."""
    lesson = teach(world, seed, config)
    yield from (search(lesson, start) for start in starts(lesson, count))


def draw(found: Mapping[str, Sequence[Search]], folder: Path) -> Path:
    """Write the curves of what `lost` said, one a world, into a folder; return the file."""
    curves = {f"{Path(world).stem}, {len(own)} starts": curve(tally(own)) for world, own in found.items()}
    path = folder / "lost.png"
    path.write_bytes(png(calibration_curve(curves, "lost, as the robot said", "share that was wrong", "starts", False)))
    return path
