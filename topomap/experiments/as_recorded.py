"""The study of what the thesis's recordings had and a simulator doesn't: headings that err, DID on whole pixels, and
colours that weigh one side of a room more than the other."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from topomap.bench.homing.contestant import Contestant, Pairwise, Referenced
from topomap.bench.homing.rows import Row
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.experiments.altered import Altered, Fade
from topomap.experiments.study import Finding, Lab, panels_finding
from topomap.vision.contracts import HomingMethod, Needs
from topomap.vision.homing import METHODS, REFERENCE_METHODS
from topomap.vision.homing.moment import Moment

ROOMS = ("ourlab", "a1original")
OFF = (0.0, 3.0, 6.0)
"""[deg] Standard deviation of the headings in which a robot is put down by hand or by its odometry."""
MATCHED = ("moment-rgb", "moment-area-rgb", "dtw-wing", "dtw-unifying", "dtw-unifying-2d")
COMPARED = ("did", "did-whole", "masks-3", "masks-3-printed")
STEPS = (0.1, 0.5)
"""[m] How far off the references are: as a robot takes them, and on the next place but one of a coarse grid."""
SHARES = (0.0, 0.25, 0.5, 1.0)
"""Of the colours' contrast."""


@dataclass(frozen=True, slots=True)
class Misheaded:
    """A method whose given compass errs: the current view is turned by a normal error of `sd_deg`."""

    method: HomingMethod[Any]  # Any: each method keeps its own kind of description
    sd_deg: float
    claims_homing: bool = True

    @property
    def needs(self) -> Needs:
        """What the method needs."""
        return self.method.needs

    def describe(self, panorama: Panorama) -> tuple[Any, Any]:
        """Return the method's description of the view, and of the view as it stands turned. Raises DataError."""
        drawn = np.random.default_rng(zlib.crc32(panorama.image.tobytes())).standard_normal()
        turned = panorama.rotated(math.radians(self.sd_deg) * float(drawn))
        return self.method.describe(panorama), self.method.describe(turned)

    def home(self, current: tuple[Any, Any], goal: tuple[Any, Any]) -> HomeVector:
        """Return the bearing [rad] of the goal, the current view turned. Raises ShapeError."""
        return self.method.home(current[1], goal[0])


def as_recorded(lab: Lab) -> Finding:
    """Headings that err, references compared by whole pixels or masks, and colours of less contrast, in two rooms."""
    panels: dict[str, Mapping[str, Row]] = {}
    for room in ROOMS:
        for off in OFF:
            panels[f"Headings off by {off:g} degrees, {room}"] = lab.rows(room, _misheaded(off))
        panels[f"References, {room}"] = lab.rows(room, _referenced())
        panels[f"Colour's contrast, {room}"] = lab.rows(room, _faded())
    return panels_finding(panels)


def _misheaded(off: float) -> Sequence[Contestant]:
    return [Pairwise(name, Misheaded(METHODS[name], off)) for name in MATCHED]


def _referenced() -> Sequence[Contestant]:
    return [Referenced(f"{name} {step:g} m", REFERENCE_METHODS[name], step) for name in COMPARED for step in STEPS]


def _faded() -> Sequence[Contestant]:
    return [Pairwise(f"laser, {share:g}", Altered(Moment(2.0, "rgb"), Fade(share))) for share in SHARES]
