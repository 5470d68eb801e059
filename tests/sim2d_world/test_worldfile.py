"""World files: what is right loads, and each mistake gives one line that says where it is and what would be right."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from sim2d import worldfile, worlds
from sim2d.errors import WorldError
from sim2d.shapes import Box, Light, Wall
from sim2d.world import World

GOOD = """
name = "den"
purpose = "tests"
ceiling_height = 2.5
goal = [1.0, 1.0]

[floor]
texture = "speckle"
gloss = 0.1

[route]
ring = [[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]]
laps = 2
tail = [[1.0, 0.8]]

[routes.back]
ring = [[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]]
both_ways = true

[[wall]]
name = "south"
points = [[0, 0], [4, 0]]
colour = [0.8, 0.7, 0.6]
decals = [{ kind = "poster", start = 1.0, length = 0.8, base = 1.0, top = 2.0, seed = 3 }]

[[wall]]
name = "rest"
points = [[4, 0], [4, 4], [0, 4], [0, 2.8]]

[[wall]]
name = "west"
points = [[0, 1.2], [0, 0]]

[[door]]
name = "exit"
a = [0, 1.2]
b = [0, 2.8]
opens_at = 1.0
closes_at = 1.5

[[polygon]]
name = "block"
points = [[1.8, 1.8], [1.8, 2.2], [2.2, 2.2], [2.2, 1.8]]
height = 1.0

[[furniture]]
kind = "shelf"
at = [3.7, 2.0]
size = [0.4, 1.0]

[[cylinder]]
name = "bin"
at = [0.4, 3.6]
radius = 0.2
height = 0.5

[[pillar]]
name = "post"
at = [3.7, 3.7]
radius = 0.1
texture = "concrete"

[[light]]
kind = "window"
wall = "south"
start = 2.0
length = 1.0

[[light]]
at = [2.0, 2.0]

[[person]]
name = "ann"
route = [[1.0, 3.4], [3.0, 3.4]]

[[change]]
name = "bin"
at_lap = 1.0
moves_to = [0.4, 3.4]
turn_deg = 90

[[change]]
name = "exit"
at_s = 20.0
opens = true

[places]
home = { x = 1.0, y = 1.0, heading_deg = 90 }

[grid]
origin = [0.5, 0.5]
spacing = 0.5
columns = 7
rows = 7

[[label]]
x = 2.0
y = 1.4
text = "den"
"""

BROKEN = {
    "unknown key": ('name = "bin"', 'nmae = "bin"', "cylinder[0].nmae = 'bin': unknown key; known here: at, colour"),
    "unknown table": ("[floor]", "[flor]", "flor = {'texture': 'speckle', 'gloss': 0.1}: unknown key"),
    "negative radius": ("radius = 0.2", "radius = -0.2", "cylinder[bin].radius = -0.2: input should be greater than 0"),
    "radius of zero": ("radius = 0.1", "radius = 0", "pillar[post].radius = 0: input should be greater than 0"),
    "NaN": ("radius = 0.2", "radius = nan", "cylinder[bin].radius = nan: input should be a finite number"),
    "infinite point": ("a = [0, 1.2]", "a = [0, inf]", "door[exit].a[1] = inf: input should be a finite number"),
    "word for a number": (
        "size = [0.4, 1.0]",
        'size = ["wide", 1.0]',
        "furniture[0].size[0] = 'wide': input should be",
    ),
    "point of three": (
        "at = [0.4, 3.6]",
        "at = [0.4, 3.6, 1]",
        "cylinder[bin].at = [0.4, 3.6, 1]: tuple should have at",
    ),
    "colour above one": ("[0.8, 0.7, 0.6]", "[0.8, 7, 0.6]", "wall[south].colour[1] = 7: input should be less than"),
    "unknown texture": (
        '"concrete"',
        '"concret"',
        "pillar[post].texture = 'concret': unknown texture; there are books",
    ),
    "unknown decal": ('"poster"', '"postr"', "wall[south].decals[0].kind = 'postr': unknown decal; there are aircon"),
    "unknown furniture": (
        '"shelf"',
        '"shelv"',
        "furniture[0].kind = 'shelv': unknown kind of furniture; there are bed",
    ),
    "missing route": ("[route]", "[routes.other]", "route = nothing: this must be given"),
    "missing walls": ("[[wall]]", "[[pillars]]", "wall = nothing: this must be given"),
    "missing radius": ("radius = 0.1\n", "", "pillar[post].radius = nothing: this must be given"),
    "missing name": ('name = "den"\n', "", "name = nothing: this must be given"),
    "one point": ("[[0, 1.2], [0, 0]]", "[[0, 1.2]]", "wall[west].points = [[0, 1.2]]: tuple should have at least 2"),
    "point twice": (
        "[[0, 1.2], [0, 0]]",
        "[[0, 1.2], [0, 1.2]]",
        "wall[west].points = [[0.0, 1.2], [0.0, 1.2]]: the po",
    ),
    "crossing polygon": (
        "[1.8, 2.2], [2.2, 2.2], [2.2, 1.8]]",
        "[2.2, 2.2], [1.8, 2.2], [2.2, 1.8]]",
        "the outline crosses itself at side 1",
    ),
    "flat polygon": (
        "[[1.8, 1.8], [1.8, 2.2], [2.2, 2.2], [2.2, 1.8]]",
        "[[1.8, 1.8], [2.0, 1.8], [2.2, 1.8]]",
        "the outline needs an area",
    ),
    "names twice": ('name = "west"', 'name = "south"', "wall[2].name = 'south': the name must be the only one of its"),
    "too high": ("height = 1.0", "height = 3.0", "polygon[block].height = 3.0: the ceiling hangs at 2.5 m"),
    "lamp above the ceiling": ("at = [2.0, 2.0]", "at = [2.0, 2.0]\nz = 2.6", "light[1].z = 2.6: the ceiling hangs at"),
    "decal past the end": ("start = 1.0, length", "start = 3.5, length", "decals[0].length = 0.8: it ends 4.3 m along"),
    "decal upside down": (
        "base = 1.0, top",
        "base = 2.1, top",
        "wall[south].decals[0] = {'kind': 'poster', 'start': 1",
    ),
    "window of no wall": (
        'wall = "south"',
        'wall = "north"',
        "light[0].wall = 'north': there is no such wall; there are",
    ),
    "window round a corner": (
        'wall = "south"',
        'wall = "rest"',
        "light[0].wall = 'rest': a window's wall must have two",
    ),
    "window past the end": ("start = 2.0", "start = 3.5", "light[0].length = 1.0: it ends 4.5 m along a wall of 4 m"),
    "lamp nowhere": ("at = [2.0, 2.0]\n", "", "light[1] = {}: a lamp needs at = [x, y]"),
    "change of nothing": (
        'name = "bin"\nat_lap',
        'name = "bim"\nat_lap',
        "change[bim].name = 'bim': there is no such th",
    ),
    "change at no time": ("at_lap = 1.0\n", "", "a change needs either at_s or at_lap"),
    "opening a bin": (
        "moves_to = [0.4, 3.4]",
        "opens = true",
        "change[bin].opens = True: only doors open, no cyl",
    ),
    "moving a door": (
        "opens = true",
        "moves_to = [1, 1]",
        "change[exit].moves_to = [1.0, 1.0]: only loose things move",
    ),
    "start inside a wall": (
        "ring = [[1.0, 1.0], [3.0, 1.0], [3.0, 3.0]",
        "ring = [[2.0, 2.0], [3.0, 1.0], [3.0, 3.0]",
        "route.ring = [2.0, 2.0]: the robot starts here, but that is inside block: keep 0.2 m free",
    ),
    "goal in a bin": (
        "goal = [1.0, 1.0]",
        "goal = [0.4, 3.6]",
        "goal = [0.4, 3.6]: the goal lies here, but that is ins",
    ),
    "place at a wall": (
        "{ x = 1.0, y = 1.0",
        "{ x = 1.0, y = 0.1",
        "places.home = [1.0, 0.1]: the place lies here, but t",
    ),
    "route through a wall": ("[3.0, 1.0], [3.0", "[5.0, 1.0], [3.0", "the way comes within 0.0"),
    "other route through a thing": (
        "ring = [[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]]",
        "ring = [[1.0, 1.0], [3.0, 3.0]]",
        "routes.back.ring = [[1.0, 1.0], [3.0, 3.0]]: at ",
    ),
    "tail of half a lap": ("laps = 2\n", "laps = 1.5\n", "a route with a tail needs whole laps"),
    "no laps": ("laps = 2\n", "laps = 0\n", "route.laps = 0: input should be greater than 0"),
    "door not on a wall": (
        "a = [0, 1.2]",
        "a = [0.3, 1.2]",
        "door[exit].a = [0.3, 1.2]: a door's ends lie on walls; the",
    ),
    "wall behind a door": (
        "[[0, 1.2], [0, 0]]",
        "[[0, 2.8], [0, 0]]",
        "west goes on behind the door: leave a gap there",
    ),
    "person through a wall": ("[3.0, 3.4]]", "[3.0, 4.4]]", "person[ann].route = [[1.0, 3.4], [3.0, 4.4]]: at "),
    "person too fast": (
        'name = "ann"',
        'name = "ann"\nspeed = 30',
        "person[ann].speed = 30: input should be less than",
    ),
    "key twice": ("origin = [0.5, 0.5]", "origin = [0.5, 0.5]\nspacing = 0.1", "not a TOML file"),
    "grid in a block": (
        "origin = [0.5, 0.5]\nspacing = 0.5",
        "origin = [1.9, 1.9]\nspacing = 0.03",
        "grid.origin = [1.9, 1.9]: no position of the grid is free",
    ),
    "grid of no columns": (
        "spacing = 0.5\ncolumns = 7\nrows = 7",
        "spacing = 0.5\ncolumns = 0\nrows = 7",
        "grid.columns = 0:",
    ),
    "no base": ('purpose = "tests"', 'extends = "nowhere"', "extends = 'nowhere': there is no "),
    "not TOML": ("[floor]", "[floor", "not a TOML file"),
}


def written(folder: Path, text: str, name: str = "den.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf8")
    return path


def test_a_good_file_is_what_it_says(tmp_path: Path) -> None:
    spec = worldfile.load(written(tmp_path, GOOD))
    assert (spec.name, spec.purpose, spec.ceiling_height, spec.floor_gloss) == ("den", "tests", 2.5, 0.1)
    assert [wall.name for wall in spec.walls] == ["south", "rest", "west"]
    assert [decal.kind for decal in spec.walls[0].look.decals] == ["poster", "window"]
    assert spec.boxes[0].points[0] == (2.2, 1.8), "a clockwise outline is turned round"
    assert [(thing.name, thing.height) for thing in spec.cylinders] == [("bin", 0.5), ("post", 2.5)]
    assert [spec.gates[0].is_open(laps) for laps in (0.9, 1.0, 1.4, 1.5)] == [False, True, True, False]
    assert spec.lights[0] == Light(2.5, 0.0, 1.5, 1.0, (1, 1, 1), "window", (2.0, 0.0), (3.0, 0.0), 0.9, 2.1)
    assert spec.changes[0].turn == pytest.approx(math.pi / 2)
    assert spec.places["home"] == pytest.approx((1.0, 1.0, math.pi / 2))
    assert spec.route_named("back").both_ways
    assert spec.route_named() == spec.route


def test_a_hollow_outline_becomes_a_closed_wall(tmp_path: Path) -> None:
    hollow = "[[1.8, 1.8], [2.0, 1.9], [2.2, 1.8], [2.0, 2.2]]"
    spec = worldfile.load(written(tmp_path, GOOD.replace("[[1.8, 1.8], [1.8, 2.2], [2.2, 2.2], [2.2, 1.8]]", hollow)))
    block = next(wall for wall in spec.walls if wall.name == "block")
    assert isinstance(block, Wall)
    assert block.points[0] == block.points[-1]
    assert not any(isinstance(box, Box) and box.name == "block" for box in spec.boxes)


def test_a_file_runs_as_a_name_does(tmp_path: Path) -> None:
    world = worlds.load(str(written(tmp_path, GOOD)))
    assert isinstance(world, World)
    assert world.name == "den"


def test_a_file_adds_to_another(tmp_path: Path) -> None:
    written(tmp_path, GOOD, "base.toml")
    more = 'extends = "base.toml"\nname = "more"\n[[cylinder]]\nname = "vase"\nat = [3.6, 0.4]\nradius = 0.1\n'
    spec = worldfile.load(written(tmp_path, more, "more.toml"))
    assert spec.name == "more"
    assert [thing.name for thing in spec.cylinders] == ["bin", "vase", "post"]


def test_files_in_a_circle_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path, 'extends = "den.toml"\n')
    with pytest.raises(WorldError, match="extend one another in a circle"):
        worldfile.load(path)


@pytest.mark.parametrize("mistake", BROKEN)
def test_a_mistake_gives_one_line(mistake: str, tmp_path: Path) -> None:
    right, wrong, message = BROKEN[mistake]
    assert right in GOOD
    path = written(tmp_path, GOOD.replace(right, wrong))
    with pytest.raises(WorldError) as caught:
        worldfile.load(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    assert message in text


def test_a_missing_file_and_a_misspelt_name_are_told(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=r"nowhere.toml: cannot be read: No such file"):
        worlds.load(str(tmp_path / "nowhere.toml"))
    with pytest.raises(WorldError, match="unknown world 'haal'; there are a1original"):
        worlds.load("haal")


def test_the_example_file_loads() -> None:
    spec = worldfile.load(Path(__file__).parents[2] / "examples" / "worlds" / "flat.toml")
    assert spec.people
    assert spec.changes
    assert spec.gates
    assert spec.routes
