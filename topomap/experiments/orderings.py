"""The study of orderings: what makes methods rank otherwise here than in the thesis's tables 3.1-3.5, 4.1, 5.1-5.3."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from topomap.bench.homing.contestant import Contestant, Pairwise, Referenced, contestant
from topomap.bench.homing.rows import Row
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.experiments.study import Finding, Lab, draw_bars, row_values
from topomap.report.figures import style
from topomap.vision.contracts import Needs
from topomap.vision.homing.comalv import ModifiedCentreOfMass
from topomap.vision.homing.did import ImageDescent
from topomap.vision.homing.min_warping import MinWarping
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.random_masks import ReferenceMasks
from topomap.vision.homing.view_vector import ViewVector
from topomap.vision.image.scale_planes import WarpingSpec

STEPS = (0.1, 0.3, 0.5)
"""[m] References as near as a robot takes them, and as the thesis's data sets have them (grids of 0.3 and 0.5 m)."""
SEEN = {
    "as taught": (),
    "six hours later": ("goal:hour=14", "hour=20"),
    "leaning by 2 degrees": ("roll_deg=2",),
}
"""What differs between real photographs of one place, and does not between two views of a simulated room."""
WARPED = ("dtw-wing", "dtw-unifying", "dtw-unifying-2d", "min-warping")
PLAIN = WarpingSpec(columns=24, phases=1, levels=4)
"""Min-warping on columns of 15 degrees without fractions: what a coarse search alone costs."""
SIGMAS = (0.0, 8.0, 32.0)
"""[columns] Low-pass of the colours before they weigh the bearings."""


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A moment that sees a panorama's colours through a low-pass along the columns, of `sigma` columns."""

    moment: Moment
    sigma: float
    claims_homing: bool = True

    @property
    def needs(self) -> Needs:
        """What the moment needs."""
        return self.moment.needs

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the moment of the smoothed panorama. Raises DataError."""
        if not self.sigma:
            return self.moment.describe(panorama)
        reach = int(3 * self.sigma)
        wide = np.concatenate([panorama.image[:, -reach:], panorama.image, panorama.image[:, :reach]], axis=1)
        soft = cv2.GaussianBlur(wide, (2 * reach + 1, 1), self.sigma)[:, reach:-reach]
        return self.moment.describe(Panorama(np.ascontiguousarray(soft), panorama.ranges, panorama.rig))

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of the goal. Raises ShapeError."""
        return self.moment.home(current, goal)


def orderings(lab: Lab) -> Finding:
    """References' distance in two rooms, what differs between photographs, and colour without its fine texture."""
    panels: dict[str, Mapping[str, Row]] = {}
    for room in ("a1original", "hall1"):
        panels[f"References, {room}"] = lab.rows(room, _referenced())
    for said, options in SEEN.items():
        panels[f"Seen {said}, ourlab"] = lab.rows("ourlab", _warped(), options)
    for room in ("a1original", "ourlab"):
        panels[f"Colour, {room}"] = lab.rows(room, _coloured())
    figure = style.canvas(7.6, 1.0 + sum(0.9 + 0.34 * len(rows) for rows in panels.values()))
    axes = figure.subplots(len(panels), 1, height_ratios=[len(rows) + 2 for rows in panels.values()])
    for one, (title, rows) in zip(axes, panels.items(), strict=True):
        draw_bars(one, title, rows)
    return Finding(figure, {title: {n: row_values(r) for n, r in rows.items()} for title, rows in panels.items()})


def _referenced() -> Sequence[Contestant]:
    methods = (("DID", ImageDescent()), ("masks", ReferenceMasks()), ("MCOMALV", ModifiedCentreOfMass()))
    return [Referenced(f"{name} {step:g} m", method, step) for name, method in methods for step in STEPS]


def _warped() -> Sequence[Contestant]:
    return [*(contestant(name) for name in WARPED), Pairwise("min-warping, 24 columns", MinWarping(PLAIN))]


def _coloured() -> Sequence[Contestant]:
    forms = (("laser", "range"), ("ground line", "ground"))
    found: list[Contestant] = []
    for said, source in forms:
        found.append(Pairwise(f"{said}, equal", Moment(2.0, "equal", distance=source)))  # type: ignore[arg-type]
        for sigma in SIGMAS:
            coloured = Moment(2.0, "rgb", distance=source)  # type: ignore[arg-type]
            found.append(Pairwise(f"{said}, colour over {sigma:g} columns", Smoothed(coloured, sigma)))
    return found
