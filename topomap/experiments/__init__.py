"""The thesis's named experiments, each with its figure: `topomap bench study NAME`."""

from __future__ import annotations

from topomap.experiments import (
    as_recorded,
    conditions,
    converging,
    hall,
    images,
    masks_score,
    moments,
    moved,
    occlusion,
    orderings,
    positions,
    ring,
    routes,
    selection,
    stationary,
)
from topomap.experiments.study import Finding, Lab, Study

LAB, ORIGINAL = ("ourlab",), ("a1original",)

STUDIES: dict[str, Study] = {
    study.name: study
    for study in (
        Study("dimension", "3.24", "which order of the moment is best?", LAB, moments.dimension),
        Study(
            "dimension-pillars", "3.9-3.12", "and among pillars alone?", ("cylinders",), moments.dimension_of_pillars
        ),
        Study("dimension-ground", "3.30", "and by the ground line?", ORIGINAL, moments.dimension_by_ground_line),
        Study("moment-classes", "3.22, 3.26, 3.27, 3.31", "which moment model is best?", ORIGINAL, moments.classes),
        Study("field-of-view", "2.12, 2.13", "how many rows are wanted?", ORIGINAL, images.field_of_view),
        Study("masks-one", "4.24, 4.25", "how many masks with one reference?", LAB, images.mask_number_one),
        Study("mask-blur", "4.34, 4.35", "do masks want a low-pass, and which?", ORIGINAL, images.mask_blur),
        Study("run-down", "5.27-5.31", "which columns should run down?", ORIGINAL, selection.run_down),
        Study("derivative-or-search", "3.29", "is searching better?", LAB, moments.derivative_or_search),
        Study("convergence-point", "3.4", "where do moments converge, by order?", LAB, converging.convergence),
        Study("potential", "3.13", "what do the moments' potentials look like?", LAB, converging.potential),
        Study("range-or-colour", "3.14, 3.15", "what does range add to colour?", LAB, moments.range_or_colour),
        Study("features", "3.16", "which colour feature weighs best?", LAB, moments.features),
        Study("vector-length", "4.34", "how long are metric home vectors?", LAB, converging.vector_length),
        Study("alignment", "2.16, 2.18", "how good is each compass over distance?", ORIGINAL, positions.alignment),
        Study("distance", "4.22", "how does the error grow with distance?", ORIGINAL, positions.distance),
        Study("homes", "3.21, 4.21, 5.28, 5.36", "does another home matter?", ORIGINAL, positions.homes),
        Study("occluded-landmarks", "2.11", "what do missing landmarks do?", (), ring.occluded),
        Study("masks", "4.28-4.32", "how many random masks are enough?", ORIGINAL, images.mask_number),
        Study("mask-repetition", "4.34", "how much does the draw of masks decide?", ORIGINAL, images.mask_repetition),
        Study("bipolar-masks", "4.17-4.22", "stages, levels, size and share of masks?", ORIGINAL, images.bipolar),
        Study("reference-spacing", "4.34", "how far off should references be?", ORIGINAL, images.reference_spacing),
        Study("blur", "2.5.3, 4.34", "how much low-pass does DID want?", ORIGINAL, images.blur),
        Study("pixels", "(DTW)", "how many columns, RGB or grey?", ORIGINAL, images.pixel_number),
        Study("dtw-inhibition", "5.40", "which of several matches should count?", ORIGINAL, images.inhibition),
        Study("dtw-search-area", "5.41", "how wide should DTW search?", ORIGINAL, images.search_area),
        Study("daylight", "5.44, 5.45", "does the hour of the day matter?", ORIGINAL, conditions.daylight),
        Study("tilt", "(tilt)", "how much tilt does each method bear?", ORIGINAL, conditions.tilt),
        Study("gain", "(exposure)", "how much gain does each method bear?", ORIGINAL, conditions.gain),
        Study("score-histogram", "4.23, 4.27", "what do mask scores say?", LAB + ORIGINAL, masks_score.score_histogram),
        Study("four-routes", "5.12-5.17", "which model homes by colour alone?", (), routes.four_routes),
        Study(
            "pixel-selection", "5.30, 5.32", "does choosing landmark pixels help?", ORIGINAL, selection.pixel_selection
        ),
        Study(
            "stationary-points", "5.34", "do two points spare a full search?", ORIGINAL, stationary.stationary_points
        ),
        Study("occlusion", "3.34", "does homing bear hidden objects?", (), occlusion.occlusion),
        Study("moved-objects", "3.35, 3.36", "does homing bear moved objects?", (), moved.moved_objects),
        Study("hall-mission", "5.50, 5.51", "do three methods come home in the hall?", ("hall",), hall.hall_missions),
        Study(
            "orderings",
            "Tables 3.1-5.3",
            "why do methods rank otherwise here?",
            ("a1original", "hall1", "ourlab"),
            orderings.orderings,
        ),
        Study(
            "as-recorded",
            "Tables 3.2-5.3",
            "what had the thesis's recordings that ours lack?",
            as_recorded.ROOMS,
            as_recorded.as_recorded,
        ),
        Study("delv", "5.33", "which DELV, how fine its distances?", ORIGINAL, images.delv),
    )
}

__all__ = ["STUDIES", "Finding", "Lab", "Study"]
