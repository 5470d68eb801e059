"""The named worlds: as large as they say, rich, free where they must be, the same each time."""

from __future__ import annotations

import math
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest

from sim2d import worlds
from sim2d.clearance import Clearance, grid_positions
from sim2d.generate.blocks import Blocks
from sim2d.generate.campus import PITCH, campus
from sim2d.path import of_route
from sim2d.shapes import Box, Cylinder, Gate, Grid, Ground, Look, Point, Route, Spec, Wall, rectangle
from sim2d.world import World

GRIDS = {
    "a1original": ((10, 17), 170),
    "screen": ((10, 17), 170),
    "arboreal": ((10, 17), 150),
    "ourlab": ((25, 25), 625),
    "hall1": ((17, 21), 300),
    "cylinders": ((19, 19), 300),
}


@pytest.mark.parametrize("name", worlds.names())
def test_every_route_has_room_and_every_goal_is_free(name: str) -> None:
    spec = worlds.spec(name)
    clearance = Clearance(spec)
    assert spec.name == name
    assert spec.purpose
    for route in (spec.route, *spec.routes.values()):
        room, thing, x, y = clearance.tightest(of_route(route).points[::10], 0.6)
        assert room > 0.25, f"{room:.2f} m beside {thing} at {x:.2f}, {y:.2f}"
    assert spec.goal is not None
    assert clearance.free(*spec.goal)
    assert clearance.free(*spec.start)


@pytest.mark.parametrize("name", GRIDS)
def test_the_grids_of_the_thesis(name: str) -> None:
    shape, free = GRIDS[name]
    positions = grid_positions(worlds.spec(name))
    assert positions.shape == (*shape, 2)
    assert np.isfinite(positions[..., 0]).sum() >= free


def test_a1original_lies_30_cm_apart() -> None:
    positions = grid_positions(worlds.spec("a1original"))
    np.testing.assert_allclose(positions[-1, -1] - positions[0, 0], (16 * 0.3, 9 * 0.3))


@pytest.mark.parametrize("name", ["screen", "arboreal"])
def test_occluders_hide_parts_of_the_room(name: str) -> None:
    """The same room with things added: from the middle of the grid more rays end nearer."""
    angles = np.linspace(0, math.tau, 720, endpoint=False)
    bare, more = (_ranges(worlds.spec(each), (2.4, 1.35), angles) for each in ("a1original", name))
    assert (more < bare - 0.1).mean() > 0.05
    assert (more <= bare + 1e-9).all()


def test_long_corridor_is_half_a_kilometre_out_and_back() -> None:
    spec = worlds.spec("long-corridor")
    path = of_route(spec.route)
    assert path.length > 1000
    assert len(path.cusps) == 1
    assert path.cusps[0] == pytest.approx(path.length / 2, rel=0.01)
    doors = {decal.start for wall in spec.walls for decal in wall.look.decals if decal.kind == "door"}
    assert len(doors) == 1, "every door looks like every other one"


@pytest.fixture(scope="module")
def grown() -> Spec:
    return campus()


def test_campus_is_5_km_and_shares_its_texels(grown: Spec) -> None:
    spec = grown
    path = of_route(spec.route)
    corners = np.array([*spec.route.ring, spec.route.ring[0]])
    driven: nx.Graph[Point] = nx.Graph()
    for a, b in pairwise(corners):
        steps = round(math.dist(a, b) / PITCH)
        stops = [tuple(p) for p in np.linspace(a, b, steps + 1)]
        nx.add_path(driven, stops)
    assert PITCH * driven.number_of_edges() > 5000, "metres of different corridors"
    assert path.length > PITCH * driven.number_of_edges() * 1.05, "some are driven again"
    world = World(spec)
    assert len(world.scene().kind) > 10_000
    assert world.atlas.texels.nbytes < 100e6


def test_campus_follows_its_seed(grown: Spec) -> None:
    assert campus(1) == grown
    assert campus(2).route != grown.route


def test_office_loop_both_ways() -> None:
    spec = worlds.spec("office-loop")
    path = of_route(spec.route_named("both-ways"))
    assert path.length == pytest.approx(of_route(spec.route).length, rel=1e-3)
    lap = path.lap
    there, back = path.at(lap - 20.0), path.at(lap + 20.0)
    assert math.dist(there, back) < 0.05, "the second lap begins with the end of the first"
    with pytest.raises(ValueError, match="world office-loop has no route 'sideways'; there are default, both-ways"):
        spec.route_named("sideways")


def test_blocks_turn_into_walls_with_the_floor_on_their_left() -> None:
    blocks = Blocks((0.0, 0.0), 1.0, 6, 6)
    blocks.cut(1, 1, 3, 2)
    blocks.cut(2, 1, 3, 4)
    edges = blocks.edges()
    assert sum(math.dist(e.a, e.b) for e in edges) == pytest.approx(10.0)
    assert len(edges) == 6
    area = 0.5 * sum(e.a[0] * e.b[1] - e.b[0] * e.a[1] for e in edges)
    assert area == pytest.approx(4.0), "counter-clockwise round the floor"


def test_doors_open_and_close_and_repeating_walls_share_a_tile() -> None:
    look = Look((0.5, 0.5, 0.5), "plain", repeat=2.0)
    ground = Ground(look)
    spec = Spec(
        "yard", Route(((0, 0), (1, 0)), 1), ground, ground, 2.5,
        walls=(Wall(((0, 5), (4, 5)), 2.5, look), Wall(((0, 6), (9, 6)), 2.5, look)),
        gates=(
            Gate((2, -1), (2, 1), 2.5, look, name="a", opens_s=3.0, closes_s=5.0),
            Gate((3, -1), (3, 1), 2.5, look, name="b", opens_m=7.0),
        ),
    )  # fmt: skip
    world = World(spec)
    assert len(world.atlas.offset) == 2, "one for the ground, one for all walls"
    assert [world.open_gates(0, s, m) for s, m in ((2, 0), (3, 0), (4, 0), (5, 7))] == [False, True, False, True]
    assert sorted(world.scene().line[:, 0]) == [0, 0, 2], "a is closed again, b is open"
    assert world.set_gate("b", False)
    assert not world.open_gates(0, 6, 8), "what was due once is not due again"


def _ranges(spec: Spec, at: Point, angles: np.ndarray) -> np.ndarray:
    """Return distances (N,) [m] found by plain geometry."""
    best = np.full(len(angles), np.inf)
    u = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    lines = [pair for wall in spec.walls for pair in zip(wall.points, wall.points[1:], strict=False)]
    lines += [pair for box in spec.boxes for pair in zip(box.points, box.points[1:] + box.points[:1], strict=True)]
    for a, b in lines:
        e, p = np.subtract(b, a), np.subtract(a, at)
        cross = u[:, 0] * e[1] - u[:, 1] * e[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (p[0] * e[1] - p[1] * e[0]) / cross
            s = (p[0] * u[:, 1] - p[1] * u[:, 0]) / cross
        best = np.where((t > 0) & (s >= 0) & (s <= 1), np.minimum(best, t), best)
    for thing in spec.cylinders:
        p = np.subtract((thing.x, thing.y), at)
        along = u @ p
        root = thing.radius**2 - (u[:, 0] * p[1] - u[:, 1] * p[0]) ** 2
        t = along - np.sqrt(np.maximum(root, 0))
        best = np.where((root > 0) & (t > 0), np.minimum(best, t), best)
    return best


def test_grid_positions_leave_out_what_is_taken() -> None:
    look = Look((0.5, 0.5, 0.5), "plain")
    ground = Ground(look)
    spec = Spec(
        "yard", Route(((0, 0), (1, 0)), 1), ground, ground, 2.5,
        boxes=(Box(rectangle(-0.1, -0.1, 0.1, 0.1), 1.0, look),),
        cylinders=(Cylinder(2.0, 1.0, 0.5, 1.0, look),),
        grid=Grid((0.0, 0.0), 1.0, 3, 2),
    )  # fmt: skip
    taken = ~np.isfinite(grid_positions(spec)[..., 0])
    assert taken.tolist() == [[True, False, False], [False, False, True]]
    assert Clearance(spec).at(0.0, 0.0)[0] == pytest.approx(-0.1)
