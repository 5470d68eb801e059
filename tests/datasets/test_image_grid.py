from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from topomap.core.errors import DataError
from topomap.datasets.grid_files import ANTWORLD_HEADER
from topomap.datasets.image_grid import grid_recipe, load_grid

WIDTH = 72


def photograph(path: Path, red_column: int) -> None:
    """A black image with one red recorded column."""
    image = np.zeros((9, WIDTH, 3), np.uint8)
    image[:, red_column, 2] = 255  # OpenCV writes BGR
    cv2.imwrite(str(path), image)


def named_grid(folder: Path, spec: str = "") -> Path:
    for i in range(3):
        for j in range(2):
            photograph(folder / f"cv_{i}_{j}.png", WIDTH // 2)
    (folder / "grid.toml").write_text(f'pattern = "cv_{{x}}_{{y}}.png"\nunit_m = 0.3\n{spec}')
    return folder


def red(folder: Path, heading: float) -> float:
    view = load_grid(folder).view(0.3, 0.3, heading)
    return view.rig.bearing(int(view.image[4, :, 0].argmax()))


def test_places_and_spacing_come_from_the_names(tmp_path: Path) -> None:
    grid = load_grid(named_grid(tmp_path))
    assert sorted(map(tuple, grid.positions.round(6))) == [(x, y) for x in (0.0, 0.3, 0.6) for y in (0.0, 0.3)]
    assert grid.spacing == pytest.approx(0.3)


def test_the_middle_column_looks_along_the_heading_and_turning_left_moves_it_right(tmp_path: Path) -> None:
    named_grid(tmp_path)
    assert red(tmp_path, 0.0) == pytest.approx(0.0)
    assert red(tmp_path, math.radians(30)) == pytest.approx(math.radians(330))


def test_headings_clockwise_from_y_are_understood(tmp_path: Path) -> None:
    named_grid(tmp_path, 'convention = "cw-from-y"\nheading_deg = 20.0\n')  # looks 70 degrees left of +x
    assert red(tmp_path, 0.0) == pytest.approx(math.radians(70))


def test_columns_run_clockwise_unless_told_otherwise(tmp_path: Path) -> None:
    named_grid(tmp_path)
    photograph(tmp_path / "cv_1_1.png", WIDTH // 2 + 6)  # 30 degrees to the right of the middle
    assert red(tmp_path, 0.0) == pytest.approx(math.radians(330))
    named_grid(tmp_path, "clockwise = false\n")
    photograph(tmp_path / "cv_1_1.png", WIDTH // 2 + 6)
    assert red(tmp_path, 0.0) == pytest.approx(math.radians(30))


def test_rows_and_height_are_what_the_spec_says(tmp_path: Path) -> None:
    rig = load_grid(named_grid(tmp_path, "horizon_row = 3.5\n")).view(0.0, 0.0, 0.0).rig
    assert (rig.width, rig.height, rig.horizon_row, rig.camera_height) == (WIDTH, 9, 3.5, 0.0)


def test_a_csv_says_where_images_are(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        photograph(tmp_path / name, 36)
    (tmp_path / "grid.csv").write_text(f"{ANTWORLD_HEADER}\n1000,2000,10,90,a.png\n1000,2100,10,90,b.png\n")
    grid = load_grid(tmp_path)
    assert grid.positions.tolist() == [[1.0, 2.0], [1.0, 2.1]]
    assert grid.shots[0].heading == pytest.approx(0.0)


def test_a_csv_file_in_a_known_format_is_a_grid_whatever_its_name(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        photograph(tmp_path / name, 36)
    route = tmp_path / "route.csv"
    route.write_text(f"{ANTWORLD_HEADER}\n1000,2000,10,90,a.png\n1000,2010,10,90,b.png\n")
    assert load_grid(route).positions == pytest.approx(np.array([[1.0, 2.0], [1.0, 2.01]]))
    arena = grid_recipe(route).arena()
    assert arena.spacing == pytest.approx(0.01)
    route.write_text("x,y\n1,2\n")
    with pytest.raises(DataError, match=r"route\.csv: its first line isn't"):
        load_grid(route)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("1,2,0,0,a.png\n1,x,0,0,a.png", r"grid.csv:3: Y \[mm\]: 'x' is no number"),
        ("1,2,0,0,a.png\n1,nan,0,0,a.png", r"grid.csv:3: Y \[mm\]: 'nan' isn't finite"),
        ("1,2,0,0,missing.png", r"grid.csv:2: there is no image 'missing.png'"),
        ("1,2,0,0,a.png\n1,2,0,0,a.png", r"stands at the place of a.png"),
        ("1,2,0,0,a.png", r"1 images are named as its spec says; a grid needs at least two"),
    ],
)
def test_mistakes_are_named_with_file_and_line(tmp_path: Path, rows: str, message: str) -> None:
    photograph(tmp_path / "a.png", 0)
    (tmp_path / "grid.csv").write_text(f"{ANTWORLD_HEADER}\n{rows}\n")
    with pytest.raises(DataError, match=message):
        load_grid(tmp_path)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ('pattern = "{x}.png"', "needs {x} and {y}"),
        ('pattern = "a{x}_{y}.png"\ncsv = "g.csv"', "say either pattern or csv"),
        ('pattern = "a{x}_{y}.png"\nunits = 1', "grid.toml: units: Extra inputs"),
        ("pattern = ", "grid.toml: can't be read"),
    ],
)
def test_mistakes_in_the_spec_are_named(tmp_path: Path, spec: str, message: str) -> None:
    (tmp_path / "grid.toml").write_text(spec)
    with pytest.raises(DataError, match=message):
        load_grid(tmp_path)


def test_a_folder_that_says_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"there is no grid\.toml"):
        load_grid(tmp_path)
    with pytest.raises(DataError, match="no such folder"):
        load_grid(tmp_path / "nowhere")


def test_a_damaged_image_and_a_place_off_the_grid_are_refused(tmp_path: Path) -> None:
    grid = load_grid(named_grid(tmp_path))
    (tmp_path / "cv_0_0.png").write_bytes(b"no image")
    with pytest.raises(DataError, match=r"cv_0_0.png: can't be read as an image"):
        grid.view(0.0, 0.0, 0.0)
    with pytest.raises(DataError, match=r"no image at 0\.15,0 m"):
        grid.view(0.15, 0.0, 0.0)


def test_a_changed_file_changes_the_identity(tmp_path: Path) -> None:
    before = grid_recipe(named_grid(tmp_path)).identity
    photograph(tmp_path / "cv_0_0.png", 3)
    assert grid_recipe(tmp_path).identity != before


def test_raw_pictures_of_a_mirror_are_unwrapped(tmp_path: Path) -> None:
    for name in ("0_0.png", "1_0.png"):
        raw = np.zeros((200, 200, 3), np.uint8)
        cv2.line(raw, (100, 100), (100, 0), (0, 0, 255), 5)  # red straight up in the picture
        cv2.imwrite(str(tmp_path / name), raw)
    (tmp_path / "grid.toml").write_text('pattern = "{x}_{y}.png"\nunwrap = "mirror.toml"\n')
    mirror = "x = 100.0\ny = 100.0\ninner = 20.0\nouter = 90.0\nforward_deg = 0.0\nwidth = 360\nheight = 40\n"
    (tmp_path / "mirror.toml").write_text(mirror)
    view = load_grid(tmp_path).view(0.0, 0.0, 0.0)
    assert view.image.shape == (40, 360, 3)
    assert view.rig.bearing(float(np.flatnonzero(view.image[20, :, 0] > 128).mean())) == pytest.approx(
        math.pi / 2, abs=0.03
    )
    (tmp_path / "mirror.toml").write_text("x = 1.0\n")
    with pytest.raises(DataError, match=r"mirror\.toml: y: Field required"):
        load_grid(tmp_path)


@pytest.mark.data
def test_antworld_is_understood_without_a_spec(data_dir: Path) -> None:
    arena = grid_recipe(data_dir / "antworld-grid").arena()
    assert len(arena.positions) == 225
    assert arena.spacing == pytest.approx(0.1, abs=1e-3)
    near = arena.source.view(*arena.home, 0.0)
    assert near.image.shape == (150, 720, 3)
    assert near.rig.horizon_row == 119.5
