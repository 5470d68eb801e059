"""Studies on image methods: masks, warping, references, pixels (chapters 2, 4 and 5)."""

from __future__ import annotations

import math
from dataclasses import replace

from topomap.bench.homing.contestant import Contestant, Pairwise, Referenced
from topomap.experiments.routes import RouteModel
from topomap.experiments.study import Finding, Lab, bars_finding, curves_finding, error_curve
from topomap.vision.homing.acv import AverageCorrectionalVector
from topomap.vision.homing.alv import AverageLandmarkVector
from topomap.vision.homing.bipolar import BipolarMasks
from topomap.vision.homing.delv import DistanceLandmarkVector
from topomap.vision.homing.did import ImageDescent
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.pixel_landmarks import PixelLandmarks
from topomap.vision.homing.random_masks import RandomMasks, ReferenceMasks
from topomap.vision.homing.skyline import SkylineHoming
from topomap.vision.image.compare import SignatureSpec
from topomap.vision.image.haar_masks import WIDE, MaskSpec
from topomap.vision.image.ring import RingSpec
from topomap.vision.matching.inhibition import Inhibition

ROOM = "a1original"


def mask_number(lab: Lab) -> Finding:
    """The number of random masks with three references, random and evenly distributed (4.24-4.32)."""
    counts = (30, 100, 300, 1000, 3000)
    series = {
        label: [Referenced(f"{label} {n}", ReferenceMasks(MaskSpec(count=n, even=even))) for n in counts]
        for label, even in (("random", False), ("evenly distributed", True))
    }
    rows = lab.rows(ROOM, [one for several in series.values() for one in several])
    curves = [error_curve(label, counts, [rows[one.name] for one in several]) for label, several in series.items()]
    return curves_finding(f"Number of masks, {ROOM}", "masks", "mean angular error [deg]", curves, log=True)


def mask_number_one(lab: Lab) -> Finding:
    """The number of masks of method 1, one reference (4.24, 4.25)."""
    counts = (100, 500, 1000, 5000)
    variants = [Pairwise(f"one reference {n}", RandomMasks(MaskSpec(count=n))) for n in counts]
    rows = lab.rows("ourlab", variants)
    curve = error_curve("one reference", counts, [rows[one.name] for one in variants])
    return curves_finding("Number of masks, ourlab", "masks", "mean angular error [deg]", [curve], log=True)


def mask_blur(lab: Lab) -> Finding:
    """Low-pass before the masks, and the best mask of each direction (4.34 b, 4.35)."""
    variants: list[Contestant] = [
        Referenced(f"sigma {s:g} columns", ReferenceMasks(replace(WIDE, blur=s))) for s in (0.0, 4.0, 12.0, 36.0)
    ]
    variants += [
        Referenced("evenly distributed", ReferenceMasks(replace(WIDE, even=True))),
        Referenced("best of each direction", ReferenceMasks(replace(WIDE, count=4000, even=True, candidates=4))),
        Referenced("sizes as printed", ReferenceMasks(MaskSpec())),
        Referenced("DID", ImageDescent()),
    ]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Masks, three references, {ROOM}", {one.name: rows[one.name] for one in variants})


def field_of_view(lab: Lab) -> Finding:
    """How many rows about the horizon are wanted (2.6.3): warping and descent by less and less, and the skyline."""
    shares = (0.02, 0.1, 0.25, 0.5, 1.0)
    warping = [
        Pairwise(f"DTW {s:g}", DynamicWarping(spec=RingSpec(top=0.5 - s / 2, bottom=0.5 + s / 2))) for s in shares
    ]
    rows = lab.rows(ROOM, [*warping, Pairwise("skyline", SkylineHoming())])
    curves = [error_curve("DTW", shares, [rows[one.name] for one in warping])]
    curves.append(error_curve("skyline", (1.0,), [rows["skyline"]]))
    return curves_finding(f"Field of view, {ROOM}", "share of the rows", "mean angular error [deg]", curves)


def mask_repetition(lab: Lab) -> Finding:
    """Ten draws of a thousand masks: how much the draw decides (4.34)."""
    variants = [Referenced(f"draw {seed}", ReferenceMasks(MaskSpec(seed=seed))) for seed in range(10)]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Repetition with other masks, {ROOM}", {one.name: rows[one.name] for one in variants})


def bipolar(lab: Lab) -> Finding:
    """Stages, levels, mask size and the share of masks kept (4.17-4.22)."""
    variants: list[Contestant] = [
        Pairwise("masks alone", BipolarMasks(stage="masks")),
        Pairwise("with matching", BipolarMasks(stage="matching", score="inverse")),
        Pairwise("with matching and filter, as printed", BipolarMasks(score="inverse")),
    ]
    variants += [Pairwise(f"levels {n}", BipolarMasks(levels=n)) for n in (1, 2, 3)]
    # the ninth level, doubled each time, would go around four times
    variants += [Pairwise(f"levels {n}, each 1.4 wider", BipolarMasks(levels=n, growth=1.4)) for n in (6, 9)]
    variants += [Pairwise(f"mask {d:g} deg", BipolarMasks(mask=math.radians(d))) for d in (2.0, 4.0, 8.0, 16.0)]
    variants += [Pairwise(f"keep {100 * k:.0f} %", BipolarMasks(kept=k)) for k in (0.1, 0.2, 0.4, 0.7, 1.0)]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Bipolar masks, {ROOM}", {one.name: rows[one.name] for one in variants})


def reference_spacing(lab: Lab) -> Finding:
    """How far from home the references are taken (4.34)."""
    steps = (0.05, 0.1, 0.2, 0.3, 0.5)
    series: dict[str, list[Contestant]] = {
        "DID": [Referenced(f"DID {s}", ImageDescent(), s) for s in steps],
        "masks, three references": [Referenced(f"masks {s}", ReferenceMasks(), s) for s in steps],
    }
    rows = lab.rows(ROOM, [one for several in series.values() for one in several])
    curves = [error_curve(label, steps, [rows[one.name] for one in several]) for label, several in series.items()]
    return curves_finding(f"Spacing of references, {ROOM}", "spacing [m]", "mean angular error [deg]", curves)


def blur(lab: Lab) -> Finding:
    """Low-pass before descent in image distance (2.5.3, 4.34)."""
    sigmas = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
    specs = [SignatureSpec(columns=90, rows=25, blur=s) for s in sigmas]
    series: dict[str, list[Contestant]] = {
        f"DID, references at {step} m": [
            Referenced(f"DID {step} {spec.blur}", ImageDescent(spec), step) for spec in specs
        ]
        for step in (0.1, 0.3)
    }
    rows = lab.rows(ROOM, [one for several in series.values() for one in several])
    degrees = [4.0 * s for s in sigmas]
    curves = [error_curve(label, degrees, [rows[one.name] for one in several]) for label, several in series.items()]
    return curves_finding(f"Low-pass, {ROOM}", "sigma [deg]", "mean angular error [deg]", curves)


def pixel_number(lab: Lab) -> Finding:
    """Columns of the ring and RGB against grey, for warping in time; (5.31) asks the same of landmark pixels."""
    columns = (45, 90, 180, 360, 720)
    series = {
        label: [Pairwise(f"{label} {n}", DynamicWarping(spec=RingSpec(columns=n, colour=colour))) for n in columns]
        for label, colour in (("RGB", True), ("grey", False))
    }
    rows = lab.rows(ROOM, [one for several in series.values() for one in several])
    curves = [error_curve(label, columns, [rows[one.name] for one in several]) for label, several in series.items()]
    return curves_finding(f"Pixels of the ring, DTW, {ROOM}", "columns", "mean angular error [deg]", curves)


def inhibition(lab: Lab) -> Finding:
    """Several starts of one target: which of them count (5.40)."""
    kinds: tuple[Inhibition, ...] = ("none", "target", "reverse", "both", "mean")
    variants = [Pairwise(kind, DynamicWarping(inhibition=kind)) for kind in kinds]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Inhibition, DTW, {ROOM}", {one.name: rows[one.name] for one in variants})


def search_area(lab: Lab) -> Finding:
    """Extra rotations that are tried after the visual compass, and the band of the warping (5.41)."""
    base = DynamicWarping(wings="wing")
    variants: list[Contestant] = [Pairwise("0 deg", base)]
    variants += [
        Pairwise(f"15 deg, {n} rotations", replace(base, swing=math.radians(15.0), rotations=n)) for n in (3, 6, 10)
    ]
    variants += [Pairwise(f"band {d:g} deg", replace(base, band=math.radians(d))) for d in (10.0, 25.0, 50.0, 90.0)]
    rows = lab.rows(ROOM, variants, compass="A1")
    return bars_finding(f"Search area, DTW, {ROOM}", {one.name: rows[one.name] for one in variants})


def delv(lab: Lab) -> Finding:
    """DELV: matched, all pairings, quantised distances, beside the pixel-wise models (5.33)."""
    variants: list[Contestant] = [
        Pairwise("M1, ground line", PixelLandmarks()),
        Pairwise("M2, grey, sorting", RouteModel(2, "sorting")),
        Pairwise("M2c, RGB, sorting", RouteModel(2, "sorting", True)),
        Pairwise("ALV", AverageLandmarkVector()),
        Pairwise("ACV", AverageCorrectionalVector()),
        Pairwise("matched", DistanceLandmarkVector()),
        Pairwise("all pairings", DistanceLandmarkVector(pairing="full")),
        *(Pairwise(f"{n} distances", DistanceLandmarkVector(levels=n)) for n in (2, 4, 8, 16)),
    ]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"DELV, {ROOM}", {one.name: rows[one.name] for one in variants})
