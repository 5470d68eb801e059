"""Studies on moments: their order, their convergence points, their potential, range and colour (chapter 3)."""

from __future__ import annotations

from topomap.bench.homing.contestant import Pairwise
from topomap.experiments.study import Finding, Lab, bars_finding, curves_finding, error_curve
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.moment import Form, Moment

ORDERS = (-1.0, 0.5, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
ROOM = "ourlab"


def dimension(lab: Lab) -> Finding:
    """The mean error over the order n, by form and with and without colour (3.9-3.12, 3.24, 3.30)."""
    forms: tuple[Form, ...] = ("gradient", "pixel", "area")
    variants = {
        f"{form}, {'range only' if feature == 'equal' else 'range and colour'}": [
            Pairwise(f"{form} {feature} {n:g}", Moment(n, feature, form)) for n in ORDERS
        ]
        for form in forms
        for feature in ("equal", "rgb")
    }
    rows = lab.rows(ROOM, [one for several in variants.values() for one in several])
    curves = [error_curve(label, ORDERS, [rows[one.name] for one in several]) for label, several in variants.items()]
    found = curves_finding(f"Order of the moment, {ROOM}", "order n", "mean angular error [deg]", curves)
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
    variants = [Pairwise(f, Moment(2.0, f)) for f in ("equal", "red", "green", "blue", "grey", "rgb", "hsv", "value")]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Feature, moment n = 2, {ROOM}", {one.name: rows[one.name] for one in variants})
