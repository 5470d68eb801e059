"""Floor plans: traced to half a cell, driven on a tour with room, and each mistake told in one line."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from sim2d import floorplan, worlds
from sim2d.clearance import Clearance
from sim2d.errors import WorldError
from sim2d.floorplan.map_file import read_map
from sim2d.path import of_route

EXAMPLE = Path(__file__).parents[2] / "examples" / "worlds" / "offices.yaml"
CELL = 0.05
YAML = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"


def plan(folder: Path, text: str = YAML, negate: bool = False) -> Path:
    """Write a map: a room of 5 x 4 m in unknown space, its walls one cell thick, with a block of 1 x 0.8 m."""
    image = np.full((100, 120), 205, np.uint8)
    image[9:91, 9:111] = 0
    image[10:90, 10:110] = 254
    image[40:56, 50:70] = 0
    cv2.imwrite(str(folder / "map.pgm"), 255 - image if negate else image)
    path = folder / "map.yaml"
    path.write_text(text, encoding="utf8")
    return path


def test_walls_are_where_the_cells_end(tmp_path: Path) -> None:
    spec = floorplan.load(plan(tmp_path))
    points = np.array([point for wall in spec.walls for point in wall.points])
    low, high = (-1.0 + 10 * CELL, 2.0 + 10 * CELL), (-1.0 + 110 * CELL, 2.0 + 90 * CELL)
    np.testing.assert_allclose(points.min(axis=0), low, atol=CELL / 2)
    np.testing.assert_allclose(points.max(axis=0), high, atol=CELL / 2)
    inner = points[(points > np.array(low) + 0.5).all(axis=1) & (points < np.array(high) - 0.5).all(axis=1)]
    np.testing.assert_allclose(inner.min(axis=0), (-1.0 + 50 * CELL, 2.0 + 44 * CELL), atol=CELL / 2)
    np.testing.assert_allclose(inner.max(axis=0), (-1.0 + 70 * CELL, 2.0 + 60 * CELL), atol=CELL / 2)


def test_a_turned_origin_turns_the_map(tmp_path: Path) -> None:
    straight = floorplan.trace(read_map(plan(tmp_path)))
    turned = floorplan.trace(read_map(plan(tmp_path, YAML.replace("0.0]", "0.5]"))))
    c, s = math.cos(0.5), math.sin(0.5)
    for a, b in zip(straight, turned, strict=True):
        np.testing.assert_allclose((a - (-1, 2)) @ np.array([[c, s], [-s, c]]) + (-1, 2), b, atol=1e-9)


def test_negated_images_say_the_same(tmp_path: Path) -> None:
    plain = read_map(plan(tmp_path)).free
    other = read_map(plan(tmp_path, YAML.replace("negate: 0", "negate: 1"), negate=True)).free
    np.testing.assert_array_equal(plain, other)


def test_lists_may_be_written_line_by_line(tmp_path: Path) -> None:
    text = "---\nimage: map.pgm  # beside this file\nresolution: 0.05\norigin:\n  - -1.0\n  - 2.0\n  - 0.0\n"
    assert read_map(plan(tmp_path, text)).origin == (-1.0, 2.0, 0.0)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_tour_has_room_and_is_the_same_each_time(seed: int, tmp_path: Path) -> None:
    spec = floorplan.load(plan(tmp_path), seed=seed)
    path = of_route(spec.route)
    assert path.length > 8
    assert Clearance(spec).tightest(path.points)[0] > 0.25
    assert spec == floorplan.load(plan(tmp_path), seed=seed)


def test_the_tour_goes_through_given_points(tmp_path: Path) -> None:
    points = ((0.0, 3.0), (4.0, 3.0), (4.0, 6.0))
    path = of_route(floorplan.load(plan(tmp_path), points).route, 1.0)
    for point in points:
        assert np.hypot(*(path.points - point).T).min() < 0.35
    with pytest.raises(WorldError, match=r"points\[1\] = \[2\.0, 4\.6\]: there must be 0\.3 m of room around it"):
        floorplan.load(plan(tmp_path), ((0.0, 3.0), (2.0, 4.6)))


def test_the_example_is_a_world() -> None:
    world = worlds.load(str(EXAMPLE))
    path = of_route(world.spec.route)
    assert world.name == "offices"
    assert path.length > 100
    assert Clearance(world.spec).tightest(path.points[::5])[0] > 0.25
    assert len(world.atlas.offset) <= 2 + 6 * 16


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("resolution: 0.05", "resolution: -1", "resolution = '-1': a number from 0.001 to 10"),
        ("resolution: 0.05", "resolution: nan", "resolution = 'nan': a number from 0.001 to 10"),
        ("resolution: 0.05\n", "", "resolution = nothing: this must be given"),
        ("image: map.pgm", "image: plan.pgm", "image = 'plan.pgm': a PGM or PNG beside it that can be read"),
        ("image: map.pgm\n", "", "image = nothing: this must be given"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0]", "origin = '[-1.0, 2.0]': three numbers [x, y, yaw]"),
        ("negate: 0", "negated: 0", "negated = '0': unknown key; known: image, resolution"),
        ("negate: 0", "mode: scale", "mode = 'scale': only trinary maps are read"),
        ("negate: 0", "free_thresh: 0.9", "free_thresh = 0.9: it must not lie above occupied_thresh, 0.65"),
        ("negate: 0", "free_thresh: 0.0", "none of them is free"),
        ("negate: 0", "negate 0", "line 4 = 'negate 0': write each key once"),
        ("resolution: 0.05", "resolution: 0.004", "nowhere is there 0.3 m of room for a robot"),
    ],
)
def test_a_mistake_gives_one_line(right: str, wrong: str, message: str, tmp_path: Path) -> None:
    path = plan(tmp_path, YAML.replace(right, wrong))
    with pytest.raises(WorldError) as caught:
        floorplan.load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
