"""The study of occlusion: homing inside, around and outside of the hull of the objects around home (3.34)."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from scipy.spatial import ConvexHull

from topomap.bench.homing.answers import Entry
from topomap.bench.homing.contestant import Contestant, Pairwise, contestant
from topomap.bench.homing.figures import vector_map
from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.evaluation.statistics import angular_errors, mean_interval
from topomap.experiments.pillars import Pillar, Room, painted, room_arena, room_recipe
from topomap.experiments.study import Curve, Finding, Lab, curve_values, draw_groups
from topomap.report.figures import style
from topomap.vision.arena import Arena, bearings_home
from topomap.vision.homing.moment import Moment

CANS, CAN, WALL = 5, 0.22, 4.0
HALF, SPACING = 2.8, 0.4
ZONES = ("inside", "around", "outside")
NEAR = 0.8
"""Places within this distance [m] of the hull lie around it, the others outside."""
MAPPED = ("moment n=2", "dtw-unifying")


def contenders() -> list[Contestant]:
    """Return the moment models on ranges alone, and ALV, ACV, DELV and warping for comparison."""
    moments = [Pairwise("moment n=2", Moment(2.0, "equal")), Pairwise("moment n=2, area", Moment(2.0, "equal", "area"))]
    return [*moments, *(contestant(name) for name in ("area-centroid", "alv", "acv", "delv", "dtw-unifying"))]


def occlusion(lab: Lab) -> Finding:
    """The error of every method by zone, with vector maps of two of them (3.34)."""
    several = contenders()
    table = lab.measured([room_recipe("cans", seed, cans_arena) for seed in lab.seeds], several)
    entries = {entry.name: entry for entry in table.entries}
    curves = [_curve(entries[one.name], lab.seeds) for one in several]
    figure = style.canvas(13.4, 5.0)
    panels = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.15))
    for axes, name in zip(panels, MAPPED, strict=False):
        vector_map(axes, entries[name])
        _draw_hull(axes, cans(lab.seeds[0]))
        axes.set_title(f"{name}, seed {lab.seeds[0]}", fontsize=9.5, loc="left")
    style.dress(panels[-1], f"inside, around and outside of the hull of {CANS} objects", "",
                "mean angular error [deg]")  # fmt: skip
    draw_groups(panels[-1], ZONES, curves)
    style.legend_below(figure, panels[-1], len(curves))
    return Finding(figure, {"zones": list(ZONES), **curve_values(curves)})


def cans(seed: int) -> Room:
    """Return a painted room with five objects around home; the seed places them and paints all."""
    rng = np.random.default_rng([seed, 334])
    angles = np.arange(CANS) * TAU / CANS + rng.uniform(-0.25, 0.25, CANS) + rng.uniform(0.0, TAU)
    reach = rng.uniform(1.1, 1.7, CANS)
    pillars = []
    for angle, distance in zip(angles, reach, strict=True):
        red, green, blue = (int(v) for v in rng.integers(20, 250, 3))
        pillars.append(Pillar(distance * math.cos(angle), distance * math.sin(angle), CAN, (red, green, blue)))
    return Room(pillars, WALL, painted(rng))


def cans_arena(name: str, seed: int, _options: tuple[str, ...]) -> Arena:
    """Return the arena of a room with objects around home."""
    return room_arena(name, cans(seed), HALF, SPACING)


def zones(positions: FloatArray, room: Room) -> FloatArray:
    """Return the zone (N,), an index of `ZONES`, of positions (N, 2) [m]."""
    hull = ConvexHull(_centres(room))
    beyond = (positions @ hull.equations[:, :2].T + hull.equations[:, 2]).max(axis=1)
    return np.asarray(np.select([beyond <= 0.0, beyond <= NEAR], [0.0, 1.0], 2.0), np.float64)


def errors_by_zone(entry: Entry, seeds: tuple[int, ...]) -> list[FloatArray]:
    """Return a method's errors [degrees] in each zone, over all seeds."""
    found: list[list[FloatArray]] = [[] for _ in ZONES]
    for seed, ground, answers in zip(seeds, entry.grounds, entry.fields, strict=True):
        positions = ground.survey.positions
        errors = angular_errors(answers.directions, bearings_home(positions, ground.home))
        zone = zones(positions, cans(seed))
        for k, part in enumerate(found):
            part.append(errors[ground.away & (zone == k)])
    return [np.concatenate(part) for part in found]


def _curve(entry: Entry, seeds: tuple[int, ...]) -> Curve:
    means = [mean_interval(part) for part in errors_by_zone(entry, seeds)]
    return Curve(entry.name, range(len(ZONES)), [m.value for m in means], [m.low for m in means],
                 [m.high for m in means])  # fmt: skip


def _draw_hull(axes: Axes, room: Room) -> None:
    centres = _centres(room)
    corners = ConvexHull(centres).vertices
    around = centres[np.append(corners, corners[0])]
    axes.plot(around[:, 0], around[:, 1], "--", color=style.GREY, linewidth=1.2, zorder=3)


def _centres(room: Room) -> FloatArray:
    return np.array([(p.x, p.y) for p in room.pillars])
