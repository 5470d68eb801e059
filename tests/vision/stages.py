"""Whatever is made of one view or two on the way to a home vector, by name; and the numbers in it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision import arena, eye_level
from topomap.vision.homing import avoiding, dp_warping, matched_filter, view_vector
from topomap.vision.homing.auto import Auto
from topomap.vision.image import (
    aligned_difference,
    colour_features,
    compare,
    displaced,
    distances,
    equalised,
    ground_line,
    haar_masks,
    keypoints,
    landmarks,
    laser_landmarks,
    pixel_selection,
    ring,
    scale_planes,
    seam,
    skyline,
    surroundings,
    unwrap,
)  # fmt: skip
from topomap.vision.matching import (
    difference_kernels,
    dtw_kernels,
    equal_distance_search,
    image_flow,
    inhibition,
    mask_scores,
    moment_potential,
    ring_flow,
    scan_match,
    scan_search,
    two_view,
    warping,
)  # fmt: skip
from topomap.vision.tilt import upright, verticals
from topomap.vision.tilt.lean import Lean

MOST = 24
"""Numbers kept of an array, evenly from all of it, with its mean, spread and magnitude."""


def numbers(thing: object) -> Iterator[float]:
    """Yield the numbers in an array, a tuple, a record of such or a number; of anything else none."""
    if dataclasses.is_dataclass(thing) and not isinstance(thing, Rig):
        for field in dataclasses.fields(thing):
            yield from numbers(getattr(thing, field.name))
    elif isinstance(thing, np.ndarray):
        flat = np.abs(thing).ravel() if np.iscomplexobj(thing) else thing.ravel().astype(float)
        yield from flat[np.unique(np.linspace(0, len(flat) - 1, MOST).astype(int))] if len(flat) else ()
        yield float(len(flat))
        if np.isfinite(flat).any():
            square = float(np.nanmean(np.square(flat)))
            yield from (float(np.nanmean(flat)), float(np.nanstd(flat)), math.log(square + 1e-30))
    elif isinstance(thing, (list, tuple)):
        for one in thing:
            yield from numbers(one)
    elif isinstance(thing, (bool, int, float, np.number, np.bool_)):
        yield float(thing)
    elif thing is None:
        yield float("nan")


def coloured(room: Panorama) -> Panorama:
    """Red and green posts, one across the seam, before a grey room."""
    image = room.image.copy()
    middle = int(room.rig.horizon_row)
    for first, width, colour in ((-3, 7, (220, 30, 20)), (60, 5, (220, 30, 20)), (140, 9, (20, 200, 40))):
        image[max(middle - 20, 0) : middle + 15, np.arange(first, first + width) % room.rig.width] = colour
    return dataclasses.replace(room, image=image)


def of_one(panorama: Panorama) -> Iterator[tuple[str, Callable[[], object]]]:
    """What is made of one view."""
    for source in ("equal", "ground", "range", "polynomial"):
        yield f"distances {source}", partial(distances.distances, panorama, source)
    for feature in ("equal", "red", "rgb", "grey", "hsv", "hsv_threshold", "bright"):
        yield f"features {feature}", partial(colour_features.features, panorama, feature)
    yield "displaced", lambda: displaced.displaced(panorama, 0.2, -0.1).image
    yield "equalised", lambda: equalised.equalised(panorama).image
    yield "ground line", partial(ground_line.ground_line, panorama)
    yield "ground ranges", partial(ground_line.ground_ranges, panorama)
    yield "haar scores", partial(haar_masks.scores, panorama, haar_masks.MaskSpec(count=200, even=True, candidates=3))
    yield "haar, blurred", partial(haar_masks.scores, panorama, haar_masks.MaskSpec(count=50, blur=2.0))
    yield "keypoints", lambda: keypoints.keypoints(panorama, keypoints.KeypointSpec()).slopes
    yield "edges", partial(landmarks.edges, panorama)
    yield "markers", partial(landmarks.markers, coloured(panorama), landmarks.MarkerSpec())
    yield "jumps", partial(laser_landmarks.jumps, panorama, laser_landmarks.JumpSpec())
    yield "selected", partial(pixel_selection.selected, panorama, 80)
    yield "by colour", partial(pixel_selection.coloured, coloured(panorama), 0.5, 0.3, 0.4)
    yield "ring", partial(ring.ring, panorama, ring.RingSpec())
    yield "grey ring", partial(ring.ring, panorama, ring.RingSpec(colour=False, bands=3, blur=0.0))
    yield "scale planes", partial(scale_planes.warping_view, panorama, scale_planes.WarpingSpec())
    yield "three phases", partial(scale_planes.warping_view, panorama, scale_planes.WarpingSpec(24, 12, 3, 2))
    yield "seam", lambda: seam.seam(np.random.default_rng(0).random((12, 40)), 0.3, 0.8)
    yield "repulsion", lambda: [avoiding.repulsion(panorama, near) for near in (0.8, 2.0, 4.0)]
    yield "skyline", partial(skyline.skyline, panorama)
    yield "surroundings", lambda: surroundings.surroundings(panorama).spectra
    yield "lean", partial(verticals.lean_of, upright.upright(panorama, Lean(-0.03, 0.04)))
    yield "upright", lambda: upright.upright(panorama, Lean(0.05, -0.02)).image
    yield "matched filter", lambda: matched_filter._upward(panorama.image[:, :, 0].astype(np.float32), 1.5)
    yield (
        "mirror",
        lambda: unwrap.fit_mirror(unwrap.wrap_up(panorama, unwrap.MirrorRig(150, 118, 29, 106, 2.1), (236, 310))),
    )
    grey = panorama.image.mean(axis=2).astype(np.float32)
    for x, y in ((grey.shape[1] - 26.0, 50.0), (180.0, len(grey) - 21.5), (31.0, 50.0), (180.0, 23.0)):
        yield f"rings about {x:g}, {y:g}", partial(unwrap._profile, grey, x, y)
    yield "arena", lambda: arena.spread(np.random.default_rng(1).random((30, 2)), (0.5, 0.4), 6)


def of_two(goal: Panorama, current: Panorama) -> Iterator[tuple[str, Callable[[], object]]]:
    """What is made of two views."""
    small = [compare.signature(one) for one in (goal, current)]
    rings = [ring.ring(one, ring.RingSpec()) for one in (goal, current)]
    planes = [scale_planes.warping_view(one, scale_planes.WarpingSpec()) for one in (goal, current)]
    points = [keypoints.keypoints(one, keypoints.KeypointSpec()) for one in (goal, current)]
    marks = [landmarks.edges(one) for one in (goal, current)]
    pictures = [image_flow.grey_view(one, 90, 24) for one in (goal, current)]
    scans = [one.ranges for one in (goal, current)]
    matches = keypoints.matched_keypoints(points[1], points[0])
    yield "difference", partial(aligned_difference.aligned_difference, current, goal, 0.3)
    yield "by rotation", partial(compare.rotation_difference, small[1], small[0])
    yield "within", partial(compare.rotation_within, small[1], small[0], 0.2, 0.5)
    yield "apart", lambda: [f(*small) for f in (compare.rms, compare.mean_abs)]
    yield "landmarks", partial(landmarks.matched, marks[1], marks[0], 0.6)
    yield "keypoints", partial(lambda: matches)
    yield "two views", partial(two_view.movement, matches, None, 0.5, two_view.EpipolarSpec())
    yield "two views, prior", partial(two_view.movement, matches, 0.1, 0.4, two_view.EpipolarSpec())
    yield "warping", lambda: dataclasses.astuple(warping.best(warping.warp(planes[1], planes[0], None, 0.6)))
    yield "warping, prior", lambda: dataclasses.astuple(warping.best(warping.warp(planes[1], planes[0], 0.2, 0.6)))
    yield "dp warping", partial(dp_warping.direction_costs, planes[1], planes[0])
    yield "flow tables", lambda: equal_distance_search.tables(36, 2, 4, 1.08, equal_distance_search.Steps())
    yield "movements", lambda: warping.movements(36, 2, 4, 1.08)
    yield "image flow", partial(image_flow.fitted_image_flow, pictures[1], pictures[0])
    yield "ring flow", partial(ring_flow.fitted_flow, rings[1], rings[0], ring_flow.FlowSpec())
    yield "measured flow", partial(ring_flow.measured_flow, rings[1], rings[0], ring_flow.FlowSpec())
    yield "dtw pairs", partial(dtw_kernels.dtw_pairs, rings[0], rings[1], 40)
    yield "dtw path", partial(dtw_kernels.dtw_path, rings[0], rings[1], 25)
    yield "blocks", partial(difference_kernels.block_differences, rings[0], rings[1], 12, 5)
    yield "rolled", partial(difference_kernels.absolute_differences, rings[1], rings[0])
    if len(marks[0]) and len(marks[1]):
        yield "inverse scores", partial(mask_scores.inverse_scores, marks[1], marks[0], 0.8, 2)
    yield "scans", lambda: scan_match.match_scans(scans[0], scans[1], np.array([0.3, 0.1, 0.05]))
    yield "scans, seen", lambda: scan_match.match_scans(scans[0], scans[1], np.array([0.3, 0.1, 0.0]), scan_match.SEEN)
    yield "scan search", partial(scan_search.places, scans[0], scans[1], 0.0, math.pi, scan_search.SearchSpec())
    yield "scan search, prior", partial(scan_search.places, scans[0], scans[1], 0.1, 0.3, scan_search.SearchSpec())
    rays = [scan_search._points(one, 72) for one in scans]
    if len(rays[0]):
        table, offsets = scan_search._table(rays[0], 0.25), np.arange(-4.0, 5.0) * 0.25
        yield "scan table", lambda: [rays, table]
        yield "scan scores", lambda: scan_search._scores(table, rays[1], offsets, 0.25)
    yield "eye level", partial(eye_level.eye_level, [(current, goal, 0.0)] * 2)
    yield "pixels", partial(pixel_selection.landmark_count, *(one.image.mean(axis=(0, 2)) for one in (current, goal)))
    yield "inhibited", _inhibited
    few, bare = Auto(points=1e9), [dataclasses.replace(one, ranges=None) for one in (current, goal)]
    yield "auto", lambda: [few.answer(current.rolled(turn), goal) for turn in (0, 41, 137)]
    yield "auto, prior", lambda: [few.answer(current.rolled(turn), goal, 0.2) for turn in (0, 41)]
    yield "auto, images", lambda: [few.answer(bare[0].rolled(turn), bare[1]) for turn in (0, 137)]
    yield (
        "rigid fit",
        lambda: moment_potential.rigid_fit(*(moment_potential.points(one[len(one) * 131 // 720 :]) for one in scans)),
    )
    yield "bearings", lambda: arena.bearings_home(np.random.default_rng(2).random((6, 2)), (0.3, 0.2))
    yield "view vector", lambda: [view_vector.vector_home(0.3, -0.2, 9.0, 0.4, metric) for metric in (False, True)]


def _inhibited() -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    home, current, unlike = rng.integers(0, 9, 30), rng.integers(0, 9, 30), rng.random(30)
    return [inhibition.inhibited(home, current, unlike, one) for one in ("target", "reverse", "both", "mean")]
