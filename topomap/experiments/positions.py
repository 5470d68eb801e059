"""Studies on where: distance from home, other homes, alignment (2.16, 2.18, 3.21, 4.21, 4.22, 5.28, 5.36)."""

from __future__ import annotations

import numpy as np

from topomap.bench.homing.contestant import contestant
from topomap.bench.homing.field import Turns, TurnsTask
from topomap.core.arrays import FloatArray
from topomap.core.geometry import wrap_all
from topomap.evaluation.statistics import angular_errors, mean_interval
from topomap.experiments.study import Curve, Finding, Lab, binned, curve_values, curves_finding, draw_groups
from topomap.report.figures import style
from topomap.vision.arena import Point, bearings_home
from topomap.vision.compass import ALIGNERS

ROOM = "a1original"
METHODS = ("dtw-unifying", "min-warping", "area-centroid", "stationary-1d", "bipolar-masks", "did")
ALIGNING = ("visual-compass", "scale-plane", "phase-correlation", "phase-scale", "rearrangement", "min-warping")


def alignment(lab: Lab) -> Finding:
    """The compass error of every aligner over the distance from home (2.16, 2.18)."""
    recipes = lab.recipes(ROOM)
    arenas = [recipe.arena() for recipe in recipes]
    asked = [TurnsTask(recipe, arena.home, ALIGNERS[name])
             for name in ALIGNING for recipe, arena in zip(recipes, arenas, strict=True)]  # fmt: skip
    found = lab.workers.run(asked, lab.advance)
    away = np.concatenate([_distance(arena.positions, arena.home) for arena in arenas])
    curves = []
    for k, name in enumerate(ALIGNING):
        own = found[k * len(recipes) : (k + 1) * len(recipes)]
        curves.append(_over_distance(name, np.concatenate([_off(turns) for turns in own]), away))
    return curves_finding(f"Alignment by distance, {ROOM}", "distance from home [m]", "compass error [deg]", curves)


def distance(lab: Lab) -> Finding:
    """The angular error of the main methods over the distance from home (4.22 d)."""
    table = lab.table(ROOM, [contestant(name) for name in METHODS])
    curves = []
    for entry in table.entries:
        errors, away = [], []
        for ground, answers in zip(entry.grounds, entry.fields, strict=True):
            true = bearings_home(ground.survey.positions, ground.home)
            errors.append(angular_errors(answers.directions, true)[ground.away])
            away.append(_distance(ground.survey.positions, ground.home)[ground.away])
        if entry.unfit is None:
            curves.append(_over_distance(entry.name, np.concatenate(errors), np.concatenate(away)))
    return curves_finding(f"Error by distance, {ROOM}", "distance from home [m]", "mean angular error [deg]", curves)


def homes(lab: Lab) -> Finding:
    """Other home positions: the middle, an edge and a corner of the grid (3.21, 4.21, 5.28, 5.36)."""
    arena = lab.recipes(ROOM)[0].arena()
    places = {"middle": arena.home, "edge": _towards(arena.positions, (1.0, 0.0)), "corner": _corner(arena.positions)}
    tables = {name: lab.table(ROOM, [contestant(one) for one in METHODS], home) for name, home in places.items()}
    curves = []
    for method in METHODS:
        rows = [next(row for row in tables[name].rows if row.method == method) for name in places]
        means = [row.mean for row in rows if row.mean is not None]
        curves.append(
            Curve(method, list(range(len(means))), [m.value for m in means], [m.low for m in means],
                  [m.high for m in means])
        )  # fmt: skip
    figure = style.canvas(7.2, 4.2)
    axes = figure.add_subplot()
    style.dress(axes, f"Home positions, {ROOM}", "home", "mean angular error [deg]")
    draw_groups(axes, [f"{name}\n{x:.1f}, {y:.1f} m" for name, (x, y) in places.items()], curves)
    style.legend_below(figure, axes, 3)
    return Finding(figure, curve_values(curves))


def _over_distance(label: str, values: FloatArray, away: FloatArray) -> Curve:
    edges = np.linspace(0.05, float(away.max()) + 1e-6, 8)
    parts = binned(values, away, edges.tolist())
    kept = [
        (float(a + b) / 2, mean_interval(part))
        for a, b, part in zip(edges, edges[1:], parts, strict=False)
        if len(part) > 2
    ]
    return Curve(
        label,
        [x for x, _ in kept],
        [m.value for _, m in kept],
        [max(m.low, 0.0) for _, m in kept],
        [m.high for _, m in kept],
    )


def _off(turns: Turns) -> FloatArray:
    return np.abs(np.degrees(wrap_all(turns.rotations - turns.headings)))


def _distance(positions: FloatArray, home: Point) -> FloatArray:
    return np.asarray(np.hypot(*(positions - np.asarray(home)).T), np.float64)


def _towards(positions: FloatArray, direction: Point) -> Point:
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
    along = positions @ np.asarray(direction)
    farthest = positions[along >= along.max() - 1e-6]
    nearest = farthest[int(np.abs(farthest - middle).sum(axis=1).argmin())]
    return float(nearest[0]), float(nearest[1])


def _corner(positions: FloatArray) -> Point:
    at = positions[int((positions.sum(axis=1)).argmin())]
    return float(at[0]), float(at[1])
