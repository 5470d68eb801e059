"""The study of the mission in the hall (5.2.4): three methods home from where the image difference was least."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from topomap.bench.homing.figures import draw_plan
from topomap.bench.homing.table import JsonValue
from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Phase
from topomap.evaluation.statistics import share_interval
from topomap.experiments.study import COLOURS, Finding, Lab
from topomap.navigation.manoeuvres.hall_course import HallCourse, HallSettings
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.report.figures import style
from topomap.vision.arena import Arena
from topomap.vision.registry import aligned_homing

HALL = "hall"
METHODS = {"DTW": "dtw-unifying", "moment, estimated distance": "moment-ground", "run-down": "run-down"}
THESIS = "5.51: one run each; all three reach home, DTW by the straightest way"
HOME = Pose2(7.0, 4.0, 0.0)
"""Where the hall's own course begins, with room for the rectangle around the pillars."""
DT, MOST = 0.25, 1200
"""Seconds a step, and the most steps of a mission: the course takes some 600."""
FORWARD, TURN = 0.02, math.radians(0.5)
"""[m, rad per sqrt m] Random errors of the odometry, as the simulated robot's; its systematic ones are calibrated."""
REACHED = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Mission:
    """One mission: the true path (K, 2) [m], the differences (K,), the step at which homing began (None: never), if
    the robot claimed home, and how far from home it ended [m].
    """

    path: FloatArray
    differences: tuple[float, ...]
    began: int | None
    claimed: bool
    error: float


class _Body:
    """A robot that moves as it is told, and an odometer with random errors."""

    def __init__(self, arena: Arena, start: Pose2, rng: np.random.Generator) -> None:
        self._arena, self._rng = arena, rng
        self.true, self.read = start, Pose2()

    def twin(self) -> _Body:
        """Return a robot that stands there as well, with the same errors to come."""
        other = copy.copy(self)
        other._rng = copy.deepcopy(self._rng)
        return other

    def view(self) -> Panorama:
        return self._arena.source.view(self.true.x, self.true.y, self.true.heading)

    def move(self, command: Command) -> None:
        way, turn = command.forward * DT, command.turn * DT
        self.true = _moved(self.true, way, turn)
        root = math.sqrt(abs(way) + 0.15 * abs(turn))
        draws = self._rng.standard_normal(2)
        self.read = _moved(self.read, way + FORWARD * root * draws[0], turn + TURN * root * draws[1])


def _moved(pose: Pose2, way: float, turn: float) -> Pose2:
    return pose @ Pose2(way * math.cos(turn / 2), way * math.sin(turn / 2), wrap(turn))


def hall_missions(lab: Lab) -> Finding:
    """The courses, image differences and ways home, with and without histogram equalisation (5.50, 5.51)."""
    figure = style.canvas(12.4, 9.4)
    panels = figure.subplots(2, 2, width_ratios=(1.25, 1.0))
    values: dict[str, JsonValue] = {"thesis": THESIS}
    for line, even in zip(panels, (False, True), strict=True):
        missions: dict[str, list[Mission]] = {name: [] for name in METHODS}
        arena = lab.recipes(HALL)[0].arena()
        for seed, recipe in zip(lab.seeds, lab.recipes(HALL), strict=True):
            arena = recipe.arena()
            for name, mission in _from_one_course(arena, seed, even).items():
                missions[name].append(mission)
            lab.advance()
        word = "equalised" if even else "as seen"
        _draw(line, arena, missions, word)
        values[word] = {name: _values(own) for name, own in missions.items()}
    return Finding(figure, values)


def _from_one_course(arena: Arena, seed: int, even: bool) -> dict[str, Mission]:
    """Return each method's mission: the course is driven once, as all notice home at the same step."""
    start = HOME
    body = _Body(arena, start, np.random.default_rng([seed, 524]))
    settings, pilot = HallSettings(equalise=even), Pilot(PilotSettings())
    course = HallCourse(settings, pilot, aligned_homing(METHODS["DTW"]))
    path, over = _drive(course, body, start, until_home_is_seen=True)
    missions = {}
    for name, method in METHODS.items():
        own = body.twin()
        went, ended = (
            (path, over)
            if over is not None
            else _drive(course.homing_by(aligned_homing(method)), own, start, until_home_is_seen=False)
        )
        whole = path if over is not None else np.vstack([path, went])
        error = float(math.dist(whole[-1], (HOME.x, HOME.y)))
        missions[name] = Mission(whole, tuple(course.differences), course.homing_from, ended is Phase.ARRIVED, error)
    return missions


def _drive(course: HallCourse, body: _Body, start: Pose2, until_home_is_seen: bool) -> tuple[FloatArray, Phase | None]:
    """Return the true path (K, 2) and how the mission ended, None where it goes on."""
    path = []
    for _ in range(MOST):
        path.append((body.true.x, body.true.y))
        command, travel = course.step(body.view(), start @ body.read, body.read)
        if travel.phase in (Phase.ARRIVED, Phase.FAILED):
            return np.array(path), travel.phase
        if until_home_is_seen and course.homing_from is not None:
            return np.array(path), None
        body.move(command)
    return np.array(path), Phase.FAILED


def _draw(line: FloatArray, arena: Arena, missions: dict[str, list[Mission]], word: str) -> None:
    routes, curve = line
    draw_plan(routes, arena.plan)
    for (name, own), colour in zip(missions.items(), COLOURS, strict=False):
        for k, mission in enumerate(own):
            began = len(mission.path) if mission.began is None else mission.began
            if name == next(iter(missions)):
                routes.plot(*mission.path[:began].T, "-", color=style.GREY, linewidth=0.7, alpha=0.5)
            routes.plot(*mission.path[began:].T, "-", color=colour, linewidth=1.3, label=name if k == 0 else None)
    routes.plot(HOME.x, HOME.y, "*", color="#FFD400", markersize=12, markeredgecolor=style.BLACK, zorder=6)
    style.dress(routes, f"Courses and ways home, views {word}", "x [m]", "y [m]")
    routes.set_aspect("equal")
    routes.legend(fontsize=8.5, frameon=False, loc="upper center", ncols=3)
    _curves(curve, next(iter(missions.values())), word)


def _curves(axes: Axes, missions: list[Mission], word: str) -> None:
    style.dress(axes, f"Image difference to home, views {word}", "step", "rms, best rotation")
    for mission in missions:
        axes.plot(mission.differences, "-", color=style.BLUE, linewidth=0.7, alpha=0.6)
        if mission.began is not None:
            axes.plot(mission.began, mission.differences[mission.began], "o", color=style.RED, markersize=4)


def _values(missions: list[Mission]) -> dict[str, JsonValue]:
    """Return how many noticed, claimed and reached home, and how far off they ended [m]."""
    noticed = [m for m in missions if m.began is not None]
    reached = sum(m.claimed and m.error <= REACHED for m in missions)
    share = share_interval(reached, len(missions))
    false = sum(m.claimed and m.error > REACHED for m in missions)
    return {
        "missions": len(missions),
        "noticed": len(noticed),
        "began_m": [round(float(math.dist(m.path[m.began or 0], m.path[0])), 2) for m in noticed],
        "claimed": sum(m.claimed for m in missions),
        "reached": reached,
        "reached_low": round(share.low, 3),
        "reached_high": round(share.high, 3),
        "false_arrivals": false,
        "error_m": [round(m.error, 3) for m in missions],
    }
