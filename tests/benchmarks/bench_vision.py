"""Milliseconds of the vision kernels at 720 x 100, one thread, beside a peer where one is installed."""

from __future__ import annotations

import importlib
import importlib.util
import math
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.mapping.places.place_index import PlaceIndex
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.compass import ALIGNERS, MinWarpingCompass, VisualCompass
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS, AreaCentroid, DynamicWarping, GoalView
from topomap.vision.image.compare import PLACE, signature, squared_differences
from topomap.vision.image.ring import RingSpec, ring
from topomap.vision.image.scale_planes import WARPING, warping_view
from topomap.vision.matching.dtw_kernels import dtw_path
from topomap.vision.matching.warping import warp

sys.path.append(str(Path(__file__).parents[1] / "vision"))
from scenes import Room

REPEATS = 25
NODES = 500
Row = dict[str, str | float | None]


def rows() -> list[Row]:
    """One row per kernel: name, ms, size, peer, peer_ms, ratio (peer_ms / ms: how many times faster)."""
    cv2.setNumThreads(1)
    room = Room()
    goal, current = room.view(3.0, 2.5, 0.0), room.view(3.4, 2.8, 0.3)
    return [
        *_compare(current, goal),
        *_warping(current, goal),
        *_dtw(current, goal),
        *_whole(current, goal),
        *_methods(current, goal),
    ]


def _compare(current: Panorama, goal: Panorama) -> list[Row]:
    index, view = PlaceIndex(), signature(current)
    stored = [signature(goal.rolled(7 * k)) for k in range(NODES)]
    for one in stored:
        index.add(one)
    sharp = VisualCompass().spec
    a, b = signature(current, sharp), signature(goal, sharp)

    def matched() -> list[Any]:
        return [_match_template(view.pixels, one.pixels) for one in stored]

    return [
        _row("signature", lambda: signature(_fresh(current), PLACE), "720x100 to 90x10"),
        _row("place search", lambda: index.search(view, 1), f"{NODES} x 90x10", "cv2.matchTemplate", matched),
        _row(
            "compass ssd",
            lambda: squared_differences(a, b.spectrum[np.newaxis]),
            "180x25",
            "cv2.matchTemplate",
            lambda: _match_template(a.pixels, b.pixels),
        ),
        _row("compass sad", lambda: VisualCompass(form="sad").curve(a, b), "180x25"),
    ]


def _match_template(current: Any, stored: Any) -> Any:
    around = np.concatenate([stored, stored[:, :-1]], axis=1)
    return cv2.matchTemplate(around, current, cv2.TM_SQDIFF)


def _warping(current: Panorama, goal: Panorama) -> list[Row]:
    a, b = warping_view(current, WARPING), warping_view(goal, WARPING)
    return [
        _row("min-warping view", lambda: warping_view(_fresh(current), WARPING), "720x100"),
        _row("min-warping full", lambda: warp(a, b), "72 columns, 9 scales"),
        _row("min-warping +-30 deg", lambda: warp(a, b, 0.2, math.radians(30)), "72 columns, 9 scales"),
    ]


def _dtw(current: Panorama, goal: Panorama) -> list[Row]:
    spec = RingSpec(columns=720, colour=False)
    a, b = ring(current, spec), ring(goal, spec)
    method = DynamicWarping()
    here, there = method.describe(current), method.describe(goal)
    return [
        *(
            _row("dtw path", lambda: dtw_path(b, a, 100), "720 columns, 5 bands, band 100", *p)
            for p in _dtw_peers(a, b)
        ),
        _row("dtw unifying", lambda: method.home(here, there), "360 columns, 15 channels, flow, cost"),
    ]


def _dtw_peers(a: Any, b: Any) -> list[tuple[str | None, Callable[[], object] | None]]:
    """Path and cost of the same sequences in the same band, by the libraries that are installed."""
    peers: list[tuple[str | None, Callable[[], object] | None]] = []
    x, y = b.T.astype(np.float64), a.T.astype(np.float64)
    if importlib.util.find_spec("tslearn"):
        metrics = importlib.import_module("tslearn.metrics")
        peers.append(
            ("tslearn", lambda: metrics.dtw_path(x, y, global_constraint="sakoe_chiba", sakoe_chiba_radius=100))
        )
    if importlib.util.find_spec("librosa"):
        sequence = importlib.import_module("librosa.sequence")
        peers.append(
            ("librosa", lambda: sequence.dtw(x.T, y.T, metric="cityblock", global_constraints=True, band_rad=100 / 720))
        )
    return peers or [(None, None)]


def _methods(current: Panorama, goal: Panorama) -> list[Row]:
    """Every method from a new view to the home vector, the goal's description kept; policies: one look."""
    turned = current.rotated(0.3)
    rows = []
    for name, method in METHODS.items():
        kept = method.describe(goal)
        rows.append(_row(f"homing {name}", partial(_pairwise, method, turned, kept), "720x100, new view"))
    for name, referenced in REFERENCE_METHODS.items():
        view = GoalView(goal, goal.rolled(1), goal.rolled(2))
        rows.append(_row(f"homing {name}", lambda r=referenced, v=view: r.home(_fresh(turned), v), "720x100, new view"))
    for name, policy in POLICIES.items():
        state = policy.start(goal)
        rows.append(_row(f"homing {name}", lambda p=policy, s=state: p.step(s, _fresh(turned)), "720x100, new view"))
    for name, aligner in ALIGNERS.items():
        rows.append(_row(f"aligner {name}", lambda a=aligner: a.align(_fresh(current), goal), "720x100, new view"))
    return rows


def _pairwise(method: Any, current: Panorama, goal: Any) -> object:
    return method.home(method.describe(_fresh(current)), goal)


def _whole(current: Panorama, goal: Panorama) -> list[Row]:
    default = AlignedHoming(MinWarpingCompass(), DynamicWarping())
    ranges = AlignedHoming(MinWarpingCompass(), AreaCentroid())
    return [
        _row("default compass + homing", lambda: default.home(_fresh(current), goal), "720x100, new view"),
        _row("compass + area centroid", lambda: ranges.home(_fresh(current), goal), "720x100, new view"),
        _row("panorama rolled", lambda: current.rotated(100 * TAU / 720), "720x100"),
    ]


def _fresh(panorama: Panorama) -> Panorama:
    """The same view with nothing derived yet."""
    return Panorama(panorama.image, panorama.ranges, panorama.rig)


def _row(
    name: str,
    call: Callable[[], object],
    size: str,
    peer: str | None = None,
    peer_call: Callable[[], object] | None = None,
) -> Row:
    ms = _milliseconds(call)
    peer_ms = _milliseconds(peer_call) if peer_call else None
    ratio = peer_ms / ms if peer_ms else None
    return {"name": name, "ms": ms, "size": size, "peer": peer, "peer_ms": peer_ms, "ratio": ratio}


def _milliseconds(call: Callable[[], object]) -> float:
    call()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))
