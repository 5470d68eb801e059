from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from topomap.bench.places import PlaceTask, read_route
from topomap.core.errors import DataError
from topomap.vision.compass import VisualCompass


def recorded(folder: Path, count: int = 12) -> Path:
    """Images of smooth noise that drifts to another along a straight metre."""
    rng = np.random.default_rng(3)
    a, b = (cv2.GaussianBlur(rng.uniform(0, 255, (20, 90, 3)), (0, 0), 2.0) for _ in range(2))
    lines = ["Time [s], Filename"]
    for i in range(count):
        mixed = (1 - i / count) * a + i / count * b
        cv2.imwrite(str(folder / f"s{i}.png"), cv2.normalize(mixed, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8))
        lines.append(f"{i}, outdoor/s{i}.png")
    (folder / "training.csv").write_text("\n".join(lines))
    (folder / "training_path_scaled.csv").write_text("".join(f"{1000 * i},{100 * i / count},0\n" for i in range(count)))
    return folder


def test_positions_are_interpolated_by_time(tmp_path: Path) -> None:
    route = read_route(recorded(tmp_path))
    assert route.positions[6] == pytest.approx((0.5, 0.0))


def test_the_nearest_map_image_and_the_known_roll_are_found(tmp_path: Path) -> None:
    score = PlaceTask(recorded(tmp_path), "visual-compass", VisualCompass(), 3, 1).perform()
    assert score.queries == 8
    assert score.place_error_m == pytest.approx(score.floor_m)
    assert score.compass_median_deg < 2.0


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("training.csv", "t, f\n1, gone.png", "training.csv:2: there is no image 'gone.png'"),
        ("training.csv", "t, f\nx, s0.png", "training.csv:2: 'x' is no number"),
        ("training_path_scaled.csv", "0,1\n", "training_path_scaled.csv:1: needs 3 fields, has 2"),
    ],
)
def test_mistakes_are_named_with_file_and_line(tmp_path: Path, file: str, text: str, message: str) -> None:
    recorded(tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(DataError, match=message):
        read_route(tmp_path)


@pytest.mark.data
def test_photographs_outdoors_are_found_again(data_dir: Path) -> None:
    score = PlaceTask(data_dir / "outdoor-teach", "visual-compass", VisualCompass(), 30, 12).perform()
    assert score.place_error_m < 0.3
    assert score.compass_median_deg < 3.0
