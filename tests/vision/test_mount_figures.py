"""What is learnt of a mount from a row of readings, by figures: the same as before."""

from __future__ import annotations

import numpy as np
import pytest
from kept import as_before

from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.tilt import mount
from topomap.vision.tilt.lean import Lean
from topomap.vision.tilt.mount import EVERY, FIRST, Mount
from topomap.vision.tilt.verticals import LeanReading

VIEW = Panorama(np.zeros((Rig().height, Rig().width, 3), np.uint8), None, Rig())
ROWS = {
    # how the mount leans and how far readings scatter, vague ones among them and some far off [rad]
    "steady": (0.04, -0.02, 0.004, 0.0, 0.1),
    "upright": (0.0, 0.001, 0.004, 0.0, 0.0),
    "swaying": (0.01, 0.03, 0.003, 0.03, 0.0),
    "moved": (0.03, 0.0, 0.003, 0.0, 0.2),
}


@pytest.mark.parametrize("name", ROWS)
def test_a_mount_is_learnt_as_before(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    roll, pitch, error, sway, far = ROWS[name]
    rng = np.random.default_rng(4)
    learnt, asked = Mount(), []

    def said(_: Panorama) -> LeanReading | None:
        asked.append(len(told))
        off = rng.normal(0.0, error, 2) + rng.normal(0.0, sway, 2) + 0.2 * (rng.random(2) < far)
        sigma = error * rng.uniform(0.5, 9.0 if rng.random() < 0.1 else 1.5)
        moved = 0.03 if name == "moved" and len(told) > 250 else 0.0
        found = Lean(roll + moved + off[0], pitch + off[1]) - learnt.lean
        return None if rng.random() < 0.1 else LeanReading(found, np.diag([sigma**2, sigma**2]))

    monkeypatch.setattr(mount, "lean_of", said)
    monkeypatch.setattr(mount, "upright", lambda view, _: view)
    told = list[float]()
    rows = []
    for k in range(520):
        taken = learnt.see(VIEW)
        told.append(learnt.restated)
        if k % 13 == 0 or learnt.restated:
            known = learnt.estimate
            rows.append([taken.lean.roll, taken.lean.pitch, learnt.restated] + (
                [known.roll, known.pitch, known.sigma, known.sway, known.taken_out] if known else [0.0] * 5
            ))  # fmt: skip
    assert asked[:FIRST] == list(range(FIRST))
    assert name != "upright" or np.diff(asked[FIRST:]).tolist() == [EVERY] * (len(asked) - FIRST - 1)
    as_before(f"mount {name}", {"rows": np.array(rows, float) * 100, "restated": np.flatnonzero(told)})
