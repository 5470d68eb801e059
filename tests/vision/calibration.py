"""Fits the automatic choice's confidence, P(error < 45 deg) from each method's evidence, on generated rooms.

Run as `python tests/vision/calibration.py`; it prints the table for `topomap/vision/homing/auto.py`. Its rooms
have other seeds than the tests'. Views are also met noisy, in thickets of stems, with blocks of another room, and
against another room's goal.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator

import numpy as np
from scenes import Room

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.vision.homing.auto import CHANCE, Answer, Auto, Choice

HOME = Pose2(3.7, 2.8, 0.4)


def trials(seeds: range, rng: np.random.Generator) -> Iterator[tuple[Panorama, Panorama, float]]:
    """Yield current, goal and the true bearing of home [rad]."""
    for seed in seeds:
        room = thicket(seed, rng) if seed % 2 else Room(seed)
        goal, other = room.at(HOME), Room(seed + 500).at(HOME)
        for _ in range(6):
            away, angle = rng.uniform(0.2, 2.2), rng.uniform(0, 2 * math.pi)
            pose = Pose2(HOME.x + away * math.cos(angle), HOME.y + away * math.sin(angle), rng.uniform(-3, 3))
            view = room.at(pose)
            for target in (goal, goal, other):
                mixed = rng.choice([0.0, 0.0, 0.4, 0.6, 0.75])
                current = spoiled(view, other, mixed, rng.choice([0.0, 0.0, 10.0, 30.0]), rng)
                truth = pose.bearing_to(HOME) if target is goal else rng.uniform(-math.pi, math.pi)
                ranged = rng.random() < 0.3
                yield (
                    (current if ranged else Panorama(current.image)),
                    (target if ranged else Panorama(target.image)),
                    truth,
                )


def thicket(seed: int, rng: np.random.Generator) -> Room:
    """Return a room full of thin stems close by: the hard case."""
    away, angle = rng.uniform(0.3, 2.5, 16), rng.uniform(0, 2 * math.pi, 16)
    stems = [
        (HOME.x + d * math.cos(a), HOME.y + d * math.sin(a), rng.uniform(0.02, 0.08), rng.uniform(0.7, 2.6))
        for d, a in zip(away, angle, strict=True)
    ]
    return Room(seed, cylinders=tuple(stems))


def spoiled(view: Panorama, other: Panorama, mixed: float, noise: float, rng: np.random.Generator) -> Panorama:
    """Return the view with a share of its columns from another room, in blocks, and with noise [grey values]."""
    image = view.image.astype(np.float64)
    foreign = np.repeat(rng.random(24) < mixed, 30)
    image[:, foreign] = other.image[:, foreign]
    if noise:
        image += rng.normal(0.0, noise, image.shape)
    return Panorama(np.clip(image, 0, 255).astype(np.uint8), view.ranges)


def measured(method: Auto, seeds: range, seed: int) -> list[tuple[Answer, bool]]:
    """Return every answer with whether it was within 45 deg."""
    results = []
    for current, goal, truth in trials(seeds, np.random.default_rng(seed)):
        answer = method.answer(current, goal)
        home = answer.alignment.home
        assert home is not None
        results.append((answer, abs(wrap(home.bearing - truth)) < math.pi / 4))
    return results


def logistic(evidence: np.ndarray, right: np.ndarray) -> float:
    """Return the slope (>= 0) of the logistic fit through chance at no evidence, with a weak prior."""
    slope = 0.0
    for _ in range(100):
        p = 1 / (1 + np.exp(-(CHANCE + slope * evidence)))
        bend = float(np.sum(p * (1 - p) * evidence**2)) + 0.05
        slope += 0.5 * (float(np.sum((right - p) * evidence)) - 0.05 * slope) / bend
    return max(slope, 0.0)


def main() -> None:
    results = []
    for near, points in ((0.6, 6.0), (9.0, 1e9), (0.0, 1e9)):  # as it is; and each fallback made to answer
        results += measured(Auto(near=near, points=points), range(100, 106), 7)
    choices: list[Choice] = ["epipolar", "range", "dtw", "warping"]
    for choice in choices:
        mine = [(a.evidence, r) for a, r in results if a.choice == choice]
        evidence, right = np.array([m[0] for m in mine]), np.array([float(m[1]) for m in mine])
        slope = logistic(evidence, right)
        sys.stdout.write(f'    "{choice}": {slope:.2f},  # {len(mine)} trials, {right.mean():.2f} right\n')


if __name__ == "__main__":
    main()
