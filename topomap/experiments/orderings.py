"""The study of orderings: what makes methods rank otherwise here than in the thesis's tables 3.1-3.5, 4.1, 5.1-5.3."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from topomap.bench.homing.contestant import Contestant, Pairwise, Referenced, contestant
from topomap.bench.homing.rows import Row
from topomap.experiments.altered import Altered, Smooth
from topomap.experiments.study import Finding, Lab, panels_finding
from topomap.vision.homing.comalv import ModifiedCentreOfMass
from topomap.vision.homing.did import ImageDescent
from topomap.vision.homing.min_warping import MinWarping
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.random_masks import ReferenceMasks
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


def orderings(lab: Lab) -> Finding:
    """References' distance in two rooms, what differs between photographs, and colour without its fine texture."""
    panels: dict[str, Mapping[str, Row]] = {}
    for room in ("a1original", "hall1"):
        panels[f"References, {room}"] = lab.rows(room, _referenced())
    for said, options in SEEN.items():
        panels[f"Seen {said}, ourlab"] = lab.rows("ourlab", _warped(), options)
    for room in ("a1original", "ourlab"):
        panels[f"Colour, {room}"] = lab.rows(room, _coloured())
    return panels_finding(panels)


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
            found.append(Pairwise(f"{said}, colour over {sigma:g} columns", Altered(coloured, Smooth(sigma))))
    return found
