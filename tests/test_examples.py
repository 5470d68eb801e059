"""Every example script runs and says something."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from sim2d import worlds
from sim2d.camera import Camera
from sim2d.config import CameraConfig

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.fixture(scope="module")
def panoramas(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Two recorded panoramas half a metre apart, for the scripts that ask for them."""
    folder, world = tmp_path_factory.mktemp("panoramas"), worlds.load("ourlab")
    camera = Camera(CameraConfig(), np.random.default_rng(0))
    paths = []
    for name, x in (("here", 2.9), ("goal", 2.4)):
        paths.append(str(folder / f"{name}.png"))
        cv2.imwrite(paths[-1], camera.view(world, x, 2.5, 0.0)[:, :, ::-1])
    return paths


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.name)
def test_the_example_runs(script: Path, panoramas: list[str], tmp_path: Path) -> None:
    words = panoramas if "sys.argv" in script.read_text() else []
    done = subprocess.run(
        [sys.executable, str(script), *words], cwd=tmp_path, capture_output=True, text=True, timeout=180, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    if words:
        assert "180" in done.stdout or "-17" in done.stdout or "+17" in done.stdout, "the goal lies behind"
