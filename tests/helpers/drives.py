"""Recordings in the TUC format, made up for tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def write_recording(folder: Path, text: str, truth: str | None = None) -> Path:
    """Write a recording's files and return the folder."""
    (folder / "Small_Input.txt").write_text(text)
    if truth is not None:
        (folder / "Small_GT.txt").write_text(truth)
    return folder


def laps(rounds: int = 3, noise: float = 0.0) -> tuple[str, str]:
    """A drive round a 20 m square at 0.5 m/s with a loop candidate for every true meeting."""
    lap = 160
    k = np.arange(rounds * lap)
    turn = np.where(k % 40 == 0, np.pi / 2 / 1.0, 0.0) + 0.002
    heading = np.cumsum(turn - 0.002)
    x, y = np.cumsum(np.cos(heading)) * 0.5, np.cumsum(np.sin(heading)) * 0.5
    rows = [f"odom2 {n} 0.5 0 {t:.6f} 0.0025 0.0025 0.0001" for n, t in zip(k, turn, strict=True)]
    rows += [f"loop {n} {n - lap} 0.8" for n in range(lap, rounds * lap, 2)]
    rows += [f"loop {n} {(n * 37) % (n - 60)} 0.6" for n in range(100, rounds * lap, 4)]
    truth = [f"point2 {n} {x[n - 1] if n else 0:.4f} {y[n - 1] if n else 0:.4f} 0 0 0 0" for n in k]
    return "\n".join(rows) + "\n", "\n".join(truth) + "\n"
