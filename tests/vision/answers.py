"""What every method and aligner answers to a few fixed views, to the last digit that machines agree on.

`python tests/vision/answers.py` writes tests/golden/answers.json anew, after a change that is meant to change answers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import numpy as np
from scenes import marker_view, plain_floor_view, view
from tolerances import ON_A_PLAIN_FLOOR

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.compass import ALIGNERS
from topomap.vision.contracts import GoalView
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS

FILE = Path(__file__).parents[1] / "golden" / "answers.json"
GOAL, NEAR, FAR = Pose2(3.7, 2.8, 0.4), Pose2(4.05, 3.0, 0.4), Pose2(2.6, 3.3, 0.4)
TURNED = 137
"""Columns by which views are turned for the aligners."""
SEEDS = {"near": NEAR, "far": FAR}
Figures = list[float | None]


def names() -> list[str]:
    """Every method, method with references, policy and aligner; aligners as `compass NAME`."""
    return [*METHODS, *REFERENCE_METHODS, *POLICIES, *(f"compass {name}" for name in ALIGNERS)]


@cache
def seen(name: str, pose: Pose2) -> Panorama:
    """The room that a method can see something in, with a gap in what it ranges."""
    if name == "alv-markers":
        return marker_view(pose)
    found = plain_floor_view(pose, 2) if name in ON_A_PLAIN_FLOOR else view(pose, 2)
    assert found.ranges is not None
    ranges = found.ranges.copy()
    ranges[100:130] = np.nan
    return replace(found, ranges=ranges)


def answers(name: str) -> dict[str, Figures]:
    """Return what one of `names()` needs, and says by the view it was given: bearing, distance, confidence.

    An aligner says rotation, residual and sharpness first.
    """
    short = name.removeprefix("compass ")
    listed = ALIGNERS[short] if name != short else {**METHODS, **REFERENCE_METHODS, **POLICIES}[name]
    needs = listed.needs  # type: ignore[union-attr]
    flags = [float(getattr(needs, f.name)) for f in fields(needs)]
    found = dict(_aligned(short) if name != short else _homed(name))
    return {"needs": [*flags, float(listed.claims_homing)], **found}  # type: ignore[union-attr]


def _homed(name: str) -> Iterator[tuple[str, Figures]]:
    goal = seen(name, GOAL)
    if name in POLICIES:
        state = POLICIES[name].start(goal)
        for k, pose in enumerate((FAR, NEAR, GOAL, FAR, NEAR, NEAR)):
            state, move = POLICIES[name].step(state, seen(name, pose))
            yield f"look {k}", _figures(move)
        return
    for said, pose in SEEDS.items():
        current = seen(name, pose)
        if name in REFERENCE_METHODS:
            method = REFERENCE_METHODS[name]
            ahead, left = (GOAL @ Pose2(*step) for step in ((method.step, 0.0), (0.0, method.step)))
            found = method.home(current, GoalView(goal, seen(name, ahead), seen(name, left), method.step))
            yield f"{said}, predicted", _figures(method.home(current, AlignedHoming.goal_view(goal, method.step)))
        else:
            found = METHODS[name].home(METHODS[name].describe(current), METHODS[name].describe(goal))
        yield said, _figures(found)
    if name in METHODS:
        there = METHODS[name].describe(goal)
        yield "same", _figures(METHODS[name].home(there, there))
        for said, blank in _nothing(goal).items():
            yield said, _figures(METHODS[name].home(METHODS[name].describe(blank), there))


def _nothing(goal: Panorama) -> dict[str, Panorama]:
    """Views that show nothing of the goal: one colour, and noise."""
    noise = np.random.default_rng(5).integers(0, 256, goal.image.shape).astype(np.uint8)
    return {"blank": replace(goal, image=np.full_like(goal.image, 99)), "noise": replace(goal, image=noise)}


def _aligned(name: str) -> Iterator[tuple[str, Figures]]:
    aligner = ALIGNERS[name]
    for said, pose in SEEDS.items():
        turned, goal = seen(name, pose).rolled(TURNED), seen(name, GOAL)
        for prior in (None, 1.0):
            found = aligner.align(turned, goal, prior)
            yield f"{said}, prior {prior}", [
                found.rotation, found.residual, float(found.sharp), *(_figures(found.home) if found.home else ())
            ]  # fmt: skip


def _figures(vector: HomeVector) -> Figures:
    return [vector.bearing, vector.distance, vector.confidence]


def main() -> None:
    """Write the answers of now."""
    text = ",\n".join(f"{json.dumps(name)}: {json.dumps(_rounded(answers(name)))}" for name in names())
    FILE.write_text(f"{{\n{text}\n}}\n", encoding="utf8")


def _rounded(found: dict[str, Figures]) -> dict[str, Figures]:
    return {said: [v if v is None else float(f"{v:.7g}") for v in figures] for said, figures in found.items()}


if __name__ == "__main__":
    main()
