"""Every figure of a report: what it is called, how it is drawn and when it applies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray
from topomap.core.run_data import RunData
from topomap.evaluation.calibration import of_run
from topomap.evaluation.closures import accepted, closures
from topomap.evaluation.journey import reference_route
from topomap.report.figures.calibration import SCORES, closure_calibration
from topomap.report.figures.closures import closure_map
from topomap.report.figures.cost import step_cost
from topomap.report.figures.differences import image_difference, place_difference
from topomap.report.figures.errors import position_error
from topomap.report.figures.home import way_home
from topomap.report.figures.panoramas import panoramas
from topomap.report.figures.precision import precision_recall
from topomap.report.figures.routes import routes


@dataclass(frozen=True, slots=True)
class FigureKind:
    """A figure: its name, a caption, the function that draws it, and why it is missing (None: it applies).

    photographs: it holds camera images, which are smaller as pixels.
    """

    name: str
    caption: str
    draw: Callable[[RunData], Figure]
    missing: Callable[[RunData], str | None]
    photographs: bool = False


def _never(run: RunData) -> str | None:
    return None if len(run.stamps_ns) else "the run has no steps"


def _no_truth(run: RunData) -> str | None:
    return "the true poses aren't known" if run.truth is None else _never(run)


def _no_difference(run: RunData) -> str | None:
    return None if _some(run.difference) else "no image difference was logged (a run without images)"


def _no_place(run: RunData) -> str | None:
    return None if _some(run.place_difference) else "no older place was ever compared"


def _no_panoramas(run: RunData) -> str | None:
    if run.first_closure:
        return None
    return "the images weren't kept" if accepted(run) else "no closure was accepted"


def _no_closures(run: RunData) -> str | None:
    return _no_truth(run) or (None if accepted(run) else "no closure was accepted")


def _no_candidates(run: RunData) -> str | None:
    return _no_truth(run) or (None if closures(run) else "no closure was ever proposed")


def _no_odds(run: RunData) -> str | None:
    if run.truth is None:
        return "the true poses aren't known"
    told = any(of_run(run, score) is not None for score in SCORES)
    return None if told else "no candidate's odds were logged"


def _no_journey(run: RunData) -> str | None:
    if run.goal_node is None:
        return "the robot wasn't asked to go home"
    return _no_truth(run) or (None if reference_route(run) is not None else "the stack never had the wheels")


def _no_timings(run: RunData) -> str | None:
    return None if any(map(_some, run.stage_ms.values())) else "no timings were logged"


def _some(values: FloatArray | None) -> bool:
    return values is not None and bool(np.isfinite(values).any())


FIGURES: tuple[FigureKind, ...] = (
    FigureKind(
        "Routes",
        "The route by dead reckoning, by the finished map and in truth over the world's plan.",
        routes,
        _never,
    ),
    FigureKind(
        "Position error",
        "Distance from the true position. Online is the estimate at the step, the final map is"
        "  the finished map's estimate of that step. Marks on the time axis are accepted closures.",
        position_error,
        _no_truth,
    ),
    FigureKind(
        "Image difference",
        "How much the view differs from the last snapshot's; above the threshold a new snapshot is kept.",
        image_difference,
        _no_difference,
    ),
    FigureKind(
        "Place difference",
        "How much the view differs from the most similar node outside the recent past (1.4: unrelated).",
        place_difference,
        _no_place,
    ),
    FigureKind(
        "Panoramas at the first closure",
        "What the robot saw before and at the first accepted closure, and the snapshot that it matched.",
        panoramas,
        _no_panoramas,
        photographs=True,
    ),
    FigureKind(
        "Closures in truth",
        "Each accepted closure joins the two true places that it claims to be one: the longer the link,"
        " the more wrong the claim. Beside it every candidate by the times of its query and its match.",
        closure_map,
        _no_closures,
    ),
    FigureKind(
        "Precision and recall of the candidates",
        "How well each score alone would tell true candidates from false ones as its threshold opens; the star is"
        " what the map accepted with all of its tests together.",
        precision_recall,
        _no_candidates,
    ),
    FigureKind(
        "Calibration of the candidates",
        "How often candidates were true revisits, by how probable that was said to be: on the dotted line a probability"
        " is what it says. Looks are a likelihood ratio, shown as if true and false ones were equally frequent.",
        closure_calibration,
        _no_odds,
    ),
    FigureKind(
        "The way home",
        "The true path after hand-over, the milestones that were planned and the goal.",
        way_home,
        _no_journey,
    ),
    FigureKind(
        "Cost of a step",
        "The stack's own time for each step as the map grows; dashed, the means of its stages.",
        step_cost,
        _no_timings,
    ),
)
