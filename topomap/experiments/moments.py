"""Studies on moments: their order, their convergence points, their potential, range and colour (chapter 3)."""

from __future__ import annotations

from topomap.bench.homing.contestant import Pairwise
from topomap.experiments.study import Finding, Lab, bars_finding, curves_finding, error_curve
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.moment import Form, Moment
from topomap.vision.image.colour_features import Feature
from topomap.vision.image.distances import Source

ORDERS = (-1.0, 0.5, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
ROOM = "ourlab"
SOURCES: tuple[tuple[Source, str], ...] = (("ground", "ground line"), ("polynomial", "polynomial"), ("range", "laser"))
FEATURE_CLASSES: tuple[tuple[Feature, str], ...] = (("equal", "equal"), ("rgb", "colour"))
FORM_CLASSES: tuple[tuple[Form, str], ...] = (("gradient", "perimeter"), ("area", "area"))
FEATURES: tuple[Feature, ...] = ("equal", "red", "green", "blue", "grey", "rgb", "hsv", "value", "hsv-threshold")
"""3.16 has blue, red, V and the threshold on H, S and V."""


def dimension(lab: Lab, room: str = ROOM, distance: Source = "range") -> Finding:
    """The mean error over the order n, by form and with and without colour (3.24; 3.9-3.12 among pillars alone, 3.30 by
    the ground line).
    """
    forms: tuple[Form, ...] = ("gradient", "pixel", "area")
    variants = {
        f"{form}, {'distance only' if feature == 'equal' else 'distance and colour'}": [
            Pairwise(f"{form} {feature} {n:g}", Moment(n, feature, form, distance)) for n in ORDERS
        ]
        for form in forms
        for feature in ("equal", "rgb")
    }
    rows = lab.rows(room, [one for several in variants.values() for one in several])
    curves = [error_curve(label, ORDERS, [rows[one.name] for one in several]) for label, several in variants.items()]
    found = curves_finding(f"Order of the moment, {room}", "order n", "mean angular error [deg]", curves)
    # from half a degree to the wrong way round
    found.figure.axes[0].set(yscale="log", ylim=(0.3, 200.0), yticks=(0.5, 1, 2, 5, 10, 20, 50, 100), xticks=ORDERS)
    found.figure.axes[0].yaxis.set_major_formatter("{x:g}")
    found.figure.axes[0].xaxis.set_major_formatter("{x:g}")
    return found


def derivative_or_search(lab: Lab) -> Finding:
    """The gradient's difference against the difference of searched convergence points (3.29)."""
    orders = (1.5, 2.0, 3.0, 4.0, 6.0)
    gradient = [Pairwise(f"gradient {n:g}", Moment(n, "equal")) for n in orders]
    search = [Pairwise(f"search {n:g}", ConvergencePoint(n)) for n in orders]
    rows = lab.rows(ROOM, [*gradient, *search])
    curves = [
        error_curve("derivative", orders, [rows[one.name] for one in gradient]),
        error_curve("convergence point", orders, [rows[one.name] for one in search]),
    ]
    return curves_finding(f"Derivative or search, {ROOM}", "order n", "mean angular error [deg]", curves)


def range_or_colour(lab: Lab) -> Finding:
    """Colour only, range only and both (3.14, 3.15)."""
    variants = [
        Pairwise("colour only", Moment(2.0, "rgb", distance="equal")),
        Pairwise("range only", Moment(2.0, "equal")),
        Pairwise("range and colour", Moment(2.0, "rgb")),
        Pairwise("range only, area", Moment(2.0, "equal", "area")),
        Pairwise("range and colour, area", Moment(2.0, "rgb", "area")),
    ]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Range or colour, moment n = 2, {ROOM}", {one.name: rows[one.name] for one in variants})


def features(lab: Lab) -> Finding:
    """The colour feature that weighs the ranges (3.16)."""
    variants = [Pairwise(f, Moment(2.0, f)) for f in FEATURES]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Feature, moment n = 2, {ROOM}", {one.name: rows[one.name] for one in variants})


def dimension_of_pillars(lab: Lab) -> Finding:
    """As 3.9 to 3.12: nothing but four pillars stands there."""
    return dimension(lab, "cylinders")


def dimension_by_ground_line(lab: Lab) -> Finding:
    """As 3.30: the distances are read off the ground line."""
    return dimension(lab, "a1original", "ground")


def classes(lab: Lab) -> Finding:
    """The moment models of tables 3.1 and 3.4: feature, source of distance, perimeter or area, and the search."""
    variants = [
        Pairwise("II colour, equal distances", Moment(2.0, "rgb", distance="equal")),
        *(
            Pairwise(f"{what}, {form}", Moment(2.0, feature, form_name, source))
            for source, by in SOURCES
            for feature, label in FEATURE_CLASSES
            for form_name, form in FORM_CLASSES
            for what in (f"{label}, {by}",)
        ),
        Pairwise("X equal, laser, searched n = 4", ConvergencePoint(4.0)),
    ]
    rows = lab.rows("a1original", variants)
    return bars_finding("Moment models, a1original", {one.name: rows[one.name] for one in variants})
