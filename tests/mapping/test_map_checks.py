"""Every rule about a map file's contents, at its bound: what just fits is let in, what just doesn't is refused."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
from maps import RIG, STEP_NS, increments, square

from topomap.mapping.graph import Node
from topomap.mapping.mapfile import to_bytes
from topomap.mapping.mapfile.checks import check_arrays, check_meta, check_views
from topomap.mapping.optimizer.problem import ClosureEdge

Arrays = dict[str, Any]


def whole() -> tuple[Arrays, Arrays]:
    """Arrays and JSON of a map that has some of everything; node 17 has no view, node 3's view no ranges."""
    topo = square()
    topo.add(Node(85 * STEP_NS, 8.5, None), increments(80, 5))
    topo.nodes[3] = replace(topo.nodes[3], snapshot=replace(topo.nodes[3].snapshot, ranges=None))
    topo.close(ClosureEdge(2, 9, topo.pose(2).to(topo.pose(9)), np.diag([0.1, 0.2, 0.01])))
    topo.experience.passed(0, 1, 2.5)
    topo.experience.failed(1, 2, 77)
    topo.places = {"desk": 3}
    with np.load(io.BytesIO(to_bytes(topo))) as file:
        arrays = {name: file[name] for name in file.files if name != "meta"}
        meta = json.loads(file["meta"].tobytes())
    arrays["turn_ends"], arrays["turns"] = np.array([[0, 1], [1, 2]]), np.array([[0.1, 0.01], [0.2, 0.02]])
    return arrays, meta


ARRAYS, META = whole()


def rigged(**values: object) -> Arrays:
    return {"rigs": [asdict(RIG) | values]}


def calibrated(**values: object) -> Arrays:
    return {"calibration": META["calibration"] | values}


FITS: list[Arrays] = [
    calibrated(rotation_scale=99.9), calibrated(rotation_scale=0.011), calibrated(distance_scale=99.9),
    calibrated(curvature=9.9), calibrated(curvature=-9.9), calibrated(distance_scale=1),
    rigged(width=16_384), rigged(width=40), rigged(height=8_192), rigged(height=1), rigged(forward_column=71),
    rigged(forward_column=0), rigged(focal=1e-9), rigged(horizon_row=-9e5), rigged(clockwise=False),
    {"rig_of": [-1] * 18}, {"places": {"d" * 64: 3}}, {"places": {"d": -1}}, {"view": "90x12x4"}, {},
    {"next_name": 2**62 - 1}, {"next_name": 0},
]  # fmt: skip
REFUSED: list[tuple[Arrays, str]] = [
    (calibrated(rotation_scale=100.0), "scales near 1"), (calibrated(distance_scale=0.01), "scales near 1"),
    (calibrated(curvature=10.0), "a curvature"), (calibrated(curvature=-10.0), "a curvature"),
    (calibrated(curvature=True), "that is numbers"), (calibrated(curvature="1"), "that is numbers"),
    ({"calibration": {"rotation_scale": 1.0}}, "calibration's mem"), (calibrated(more=1.0), "calibration's mem"),
    (rigged(width=16_385), "width"), (rigged(width=1), "width"), (rigged(width=72.0), "width"),
    (rigged(height=8_193), "height"), (rigged(height=0), "height"), (rigged(height=True), "height"),
    (rigged(forward_column=72), "forward column"), (rigged(forward_column=-1), "forward column"),
    (rigged(clockwise=1), "direction"), (rigged(focal=0.0), "focal length"), (rigged(horizon_row=1e6), "horizon"),
    (rigged(camera_height=float("nan")), "numbers"), ({"rig_of": [1] * 18}, "a rig for each view"),
    ({"rig_of": [-2] * 18}, "a rig for each view"), ({"rig_of": [0.0] * 18}, "a rig for each view"),
    ({"places": {"": 3}}, "places"), ({"places": {"d" * 65: 3}}, "places"), ({"places": {"d": 3.0}}, "places"),
    ({"places": [3]}, "places"), ({"next_name": 2**62}, "next number"), ({"next_name": -1}, "next number"),
    ({"next_name": 3.0}, "next number"), ({"view": "1x1x1"}, "columns"),
]  # fmt: skip


@pytest.mark.parametrize("change", FITS, ids=range(len(FITS)))
def test_a_meta_at_its_bound_is_let_in(change: Arrays) -> None:
    check_meta(META | change)


@pytest.mark.parametrize(("change", "says"), REFUSED, ids=range(len(REFUSED)))
def test_a_meta_beyond_its_bound_is_refused(change: Arrays, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        check_meta(META | change)


def at(name: str, where: object, value: object) -> Callable[[Arrays], None]:
    def change(arrays: Arrays) -> None:
        arrays[name] = arrays[name].copy()
        arrays[name][where] = value

    return change


def cut(name: str) -> Callable[[Arrays], None]:
    return lambda arrays: arrays.update({name: arrays[name][:-1]})


def both(*changes: Callable[[Arrays], None]) -> Callable[[Arrays], None]:
    return lambda arrays: [change(arrays) for change in changes] and None


FLAT = np.diag([1.0, 0.0, 1.0])
SKEW = np.eye(3) + np.array([[0.0, 1e-5, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
BENT = np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FINE: list[Callable[[Arrays], None]] = [
    lambda arrays: None, at("poses", (3, 0), 9e7), at("deltas", (3, 0), -9e7), at("covariances", 3, FLAT),
    at("covariances", 3, np.zeros((3, 3))), at("covariances", 3, np.eye(3) + 1e-8 * BENT), at("closure_weight", 0, 1.0),
    at("closure_weight", 0, 0.001), at("turns", (0, 1), 1e-9), at("experience_seconds", 0, 0.0),
    at("experience_counts", (0, 0), 0), at("ranges", 5, 0.0), at("ranges", 5, np.nan), at("names", 17, 900),
    at("jumps", 1, True), at("closure_ends", 0, [0, 17]), at("turn_ends", 0, [17, 0]),
]  # fmt: skip
WRONG: list[tuple[Callable[[Arrays], None], str]] = [
    *((cut(name), f"{name} for 18 nodes")
      for name in ("travel", "poses", "names", "chain", "jumps", "image_ends", "has_ranges")),
    *((at(name, 0, np.inf), f"numbers in {name}")
      for name in ("travel", "poses", "deltas", "covariances", "closure_relative", "closure_covariance",
                   "closure_weight", "turns", "experience_seconds")),
    (at("poses", (3, 0), 1e8), "poses on this planet"), (at("deltas", (3, 0), -1e8), "odometry on this planet"),
    (at("names", 0, -1), "a number of its own"), (at("names", 0, 1), "a number of its own"),
    (at("chain", 0, 1), "a chain of all nodes"), (at("stamps_ns", 3, 15 * STEP_NS + STEP_NS * 5), "stamps that rise"),
    (at("stamps_ns", 17, 2**62), "stamps of this age"), (at("jumps", 0, True), "a first node"),
    (at("image_ends", 17, 10**6), "image ends"), (cut("images"), "image ends"),
    (at("image_ends", 3, 0), "image ends"), (at("has_ranges", 17, True), "ranges only beside"),
    (at("has_ranges", 3, True), "ranges"), (cut("ranges"), "ranges"), (at("ranges", 5, -0.01), "aren't negative"),
    (cut("edge_ends"), "17 odometry edges"), (at("edge_ends", 3, 15), "odometry on each edge"),
    *((cut(name), f"85 increments in {name}") for name in ("increment_stamps_ns", "deltas", "covariances")),
    (at("increment_stamps_ns", 3, 3 * STEP_NS), "order of time"),
    (at("increment_stamps_ns", 84, 86 * STEP_NS), "ends at the nodes"),
    (at("increment_stamps_ns", 0, 0), "after the first node"),
    (at("covariances", (3, 1, 1), -1e-9), "variances in covariances"), (at("covariances", 3, SKEW), "symmetry"),
    (at("covariances", 3, BENT), "covariances in covariances"), (at("closure_covariance", 0, SKEW), "symmetry"),
    (at("closure_covariance", 0, FLAT), "closures with a covariance"),
    *((cut(name), f"2 closures in {name}") for name in ("closure_relative", "closure_covariance", "closure_weight")),
    (cut("turns"), "2 turns"), (cut("experience_counts"), "rows in experience_counts"),
    (cut("experience_seconds"), "rows in experience_seconds"),
    (at("experience_counts", (0, 1), -1), "passages that are counted"),
    (at("experience_seconds", 0, -0.1), "passages that take time"),
    *((at(name, 0, [0, 18]), "between nodes that there are") for name in ("closure_ends", "turn_ends")),
    *((at(name, 0, [-1, 3]), "between nodes that there are") for name in ("turn_ends", "experience_ends")),
    *((at(name, 0, [3, 3]), "between two nodes") for name in ("closure_ends", "turn_ends", "experience_ends")),
    (at("closure_weight", 0, 0.0), "weights up to 1"), (at("closure_weight", 0, 1.01), "weights up to 1"),
    (at("turns", (0, 1), 0.0), "turns with a sigma"),
]  # fmt: skip


@pytest.mark.parametrize("change", FINE, ids=range(len(FINE)))
def test_arrays_at_their_bound_are_let_in(change: Callable[[Arrays], None]) -> None:
    arrays = dict(ARRAYS)
    change(arrays)
    check_arrays(arrays, META)


@pytest.mark.parametrize(("change", "says"), WRONG, ids=range(len(WRONG)))
def test_arrays_beyond_their_bound_are_refused(change: Callable[[Arrays], None], says: str) -> None:
    arrays = dict(ARRAYS)
    change(arrays)
    with pytest.raises(ValueError, match=says):
        check_arrays(arrays, META)


def test_places_and_rigs_fit_the_nodes() -> None:
    for meta, says in (
        ({"rig_of": META["rig_of"][:-1]}, "rig_of for 18"),
        ({"places": {"desk": 99}}, "places at nodes"),
    ):
        with pytest.raises(ValueError, match=says):
            check_arrays(dict(ARRAYS), META | meta)
    with pytest.raises(ValueError, match="an image for each rig"):
        check_arrays(dict(ARRAYS), META | {"rig_of": [0] * 18})


def test_a_view_is_of_its_rigs_size() -> None:
    node = square().nodes[0]
    assert node.snapshot is not None
    png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + (72).to_bytes(4, "big") + (10).to_bytes(4, "big")
    check_views([node, replace(node, snapshot=replace(node.snapshot, encoded=png)), replace(node, snapshot=None)])
    wide = replace(RIG, width=73)
    with pytest.raises(ValueError, match=r"the view of node 1 is \(72, 10\) pixels, its rig says \(73, 10\)"):
        check_views([node, replace(node, snapshot=replace(node.snapshot, encoded=png, rig=wide))])
