"""What must hold of a map file's contents: every array held against the others before anything is built of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from topomap.core.encoded import image_size
from topomap.core.errors import DataError
from topomap.core.geometry import TAU
from topomap.core.recorded import RecordedRig
from topomap.core.view_size import parse_view
from topomap.mapping.graph import Node
from topomap.mapping.mapfile.archive import Array

MOST = 200_000
"""Nodes, closures or turns: a hundred kilometres at two a metre. Each takes some kilobytes when it is loaded."""
WIDEST, HIGHEST = 16_384, 8_192  # [pixels]
LONGEST_NAME = 64
LAST_NAME = 2**62  # numbers stay numbers, however many maps are merged
FARTHEST = 1e8  # [m] sums of squares of positions stay numbers
EVENLY = 1e-6  # share by which a covariance may be unlike its transpose


def check_meta(meta: dict[str, Any]) -> None:
    """Raises ValueError, TypeError or KeyError where the JSON part isn't what it must be."""
    calibration = meta["calibration"]
    _must(set(calibration) == {"rotation_scale", "curvature", "distance_scale"}, "the calibration's members")
    _must(all(_number(value) for value in calibration.values()), "a calibration that is numbers")
    scales = calibration["rotation_scale"], calibration["distance_scale"]
    _must(all(0.01 < scale < 100.0 for scale in scales), "scales near 1")
    _must(abs(calibration["curvature"]) < 10.0, "a curvature below 10 rad/m")
    _must(len(meta["rigs"]) <= MOST, "fewer rigs")
    for rig in meta["rigs"]:
        _check_rig(rig)
    rigs = meta["rig_of"]
    _must(all(type(k) is int and -1 <= k < len(meta["rigs"]) for k in rigs), "a rig for each view")
    places = meta.get("places", {})
    _must(isinstance(places, dict), "places by name")
    _must(all(0 < len(name) <= LONGEST_NAME and type(node) is int for name, node in places.items()), "places by name")
    following = meta.get("next_name", 0)
    _must(type(following) is int and 0 <= following < LAST_NAME, "a next number that is a number")
    try:
        parse_view(meta.get("view", "full"))
    except DataError as error:
        raise ValueError(str(error)) from error


def rig_of(members: dict[str, Any]) -> RecordedRig:
    """Return a rig by its members in JSON. Raises TypeError or ValueError where it isn't one."""
    return RecordedRig(**members | {"hidden": tuple((start, extent) for start, extent in members.get("hidden", ()))})


def _check_rig(rig: dict[str, Any]) -> None:
    own = rig_of(rig)
    _must(type(own.width) is int and 1 < own.width <= WIDEST, "a rig's width in pixels")
    _must(type(own.height) is int and 0 < own.height <= HIGHEST, "a rig's height in pixels")
    _must(type(own.forward_column) is int and 0 <= own.forward_column < own.width, "a rig's forward column")
    _must(type(own.clockwise) is bool, "a rig's direction")
    _must(all(map(_number, (own.horizon_row, own.focal, own.camera_height))), "a rig that is numbers")
    _must(all(_number(lean) and abs(lean) < 1.0 for lean in (own.roll, own.pitch)), "a camera that leans by less")
    _must(len(own.hidden) <= own.width, "fewer hidden parts than columns")
    for span in own.hidden:
        _must(all(_number(angle) and 0.0 <= angle <= TAU for angle in span), "hidden parts within a turn")
    _must(own.focal > 0 and abs(own.horizon_row) < 1e6, "a rig's focal length and horizon")


def _number(value: object) -> bool:
    return type(value) in (int, float) and bool(np.isfinite(float(value)))  # type: ignore[arg-type]


def check_arrays(arrays: dict[str, Array], meta: dict[str, Any]) -> None:
    """Raises ValueError where lengths, ranges, indices or numbers don't fit together."""
    count = len(arrays["stamps_ns"])
    _must(0 < count <= MOST, f"1 to {MOST} nodes")
    for name in ("travel", "poses", "names", "chain", "jumps", "image_ends", "has_ranges"):
        _must(len(arrays[name]) == count, f"{name} for {count} nodes")
    _must(len(meta["rig_of"]) == count, f"rig_of for {count} nodes")
    for name in ("travel", "poses", "deltas", "covariances", "closure_relative", "closure_covariance",
                 "closure_weight", "turns", "experience_seconds"):  # fmt: skip
        _must(bool(np.isfinite(arrays[name]).all()), f"numbers in {name}")
    _must(bool((np.abs(arrays["poses"]) < FARTHEST).all()), "poses on this planet")
    _must(bool((np.abs(arrays["deltas"]) < FARTHEST).all()), "odometry on this planet")
    _check_chain(arrays, count)
    _check_views(arrays, meta)
    _check_increments(arrays, count)
    _check_edges(arrays, count)
    known = set(arrays["names"].tolist())
    _must(all(node in known for node in meta.get("places", {}).values()), "places at nodes that there are")


def _check_chain(arrays: dict[str, Array], count: int) -> None:
    chain, names = arrays["chain"], arrays["names"]
    _must(bool((np.sort(chain) == np.arange(count)).all()), "a chain of all nodes")
    _must(len(np.unique(names)) == count and names.min() >= 0, "a number of its own for each node")
    stamps = arrays["stamps_ns"][chain]
    _must(bool((stamps[1:] > stamps[:-1]).all()), "stamps that rise along the chain")
    _must(bool((np.abs(arrays["stamps_ns"].astype(float)) < 2.0**62).all()), "stamps of this age")
    _must(not arrays["jumps"][0], "a first node that nothing is before")


def _check_views(arrays: dict[str, Array], meta: dict[str, Any]) -> None:
    rig_of, ends = np.array(meta["rig_of"], np.int64), arrays["image_ends"]
    sizes = np.diff(ends, prepend=0)
    _must(bool((sizes >= 0).all()) and ends[-1] == len(arrays["images"]), "image ends within the images")
    _must(bool(((sizes > 0) == (rig_of >= 0)).all()), "an image for each rig and none without")
    has = arrays["has_ranges"]
    _must(not has[rig_of < 0].any(), "ranges only beside an image")
    widths = np.array([rig["width"] for rig in meta["rigs"]], np.int64)
    wanted = int(widths[rig_of[has]].sum()) if has.any() else 0
    _must(len(arrays["ranges"]) == wanted, f"{wanted} ranges")
    _must(not (arrays["ranges"] < 0).any(), "ranges that aren't negative")


def _check_increments(arrays: dict[str, Array], count: int) -> None:
    ends, stamps = arrays["edge_ends"], arrays["increment_stamps_ns"]
    _must(len(ends) == count - 1, f"{count - 1} odometry edges")
    _must(bool((np.diff(ends, prepend=0) > 0).all()), "odometry on each edge")
    steps = int(ends[-1]) if count > 1 else 0
    for name in ("increment_stamps_ns", "deltas", "covariances"):
        _must(len(arrays[name]) == steps, f"{steps} increments in {name}")
    _must(bool((stamps[1:] > stamps[:-1]).all()), "increments in the order of time")
    if count > 1:
        at_end = arrays["stamps_ns"][arrays["chain"][1:]]
        _must(bool((stamps[ends - 1] == at_end).all()), "odometry that ends at the nodes")
        _must(bool(stamps[0] > arrays["stamps_ns"][arrays["chain"][0]]), "odometry after the first node")
    _check_covariances(arrays["covariances"], "covariances")


def _check_covariances(covariances: Array, name: str) -> None:
    _must(bool((covariances.diagonal(axis1=1, axis2=2) >= 0).all()), f"variances in {name}")
    uneven = np.abs(covariances - covariances.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
    _must(bool((uneven <= EVENLY * np.abs(covariances).max(axis=(1, 2), initial=0.0)).all()), f"symmetry in {name}")
    if len(covariances):
        least = np.linalg.eigvalsh(covariances)[:, 0]
        _must(bool((least >= -EVENLY * np.abs(covariances).max(axis=(1, 2))).all()), f"covariances in {name}")


def _check_edges(arrays: dict[str, Array], count: int) -> None:
    ends, turns = arrays["closure_ends"], arrays["turn_ends"]
    for name in ("closure_relative", "closure_covariance", "closure_weight"):
        _must(len(arrays[name]) == len(ends) <= MOST, f"{len(ends)} closures in {name}")
    _must(len(arrays["turns"]) == len(turns) <= MOST, f"{len(turns)} turns")
    known = arrays["experience_ends"]
    for name in ("experience_counts", "experience_seconds"):
        _must(len(arrays[name]) == len(known) <= 2 * MOST, f"{len(known)} rows in {name}")
    _must(bool((arrays["experience_counts"][:, :2] >= 0).all()), "passages that are counted")
    _must(bool((arrays["experience_seconds"] >= 0).all()), "passages that take time")
    for pairs, name in ((ends, "closures"), (turns, "turns"), (known, "experience")):
        _must(bool(((pairs >= 0) & (pairs < count)).all()), f"{name} between nodes that there are")
        _must(bool((pairs[:, 0] != pairs[:, 1]).all()), f"{name} between two nodes")
    _must(bool((arrays["closure_weight"] > 0).all() and (arrays["closure_weight"] <= 1).all()), "weights up to 1")
    _must(bool((arrays["turns"][:, 1] > 0).all()), "turns with a sigma")
    _check_covariances(arrays["closure_covariance"], "closure_covariance")
    if len(ends):
        _must(bool((np.linalg.eigvalsh(arrays["closure_covariance"])[:, 0] > 0).all()), "closures with a covariance")


def check_views(nodes: Sequence[Node]) -> None:
    """Raises ValueError where an image isn't of its rig's size; told by its first bytes, undecoded."""
    for k, node in enumerate(nodes):
        if node.snapshot is not None:
            rig, size = node.snapshot.rig, image_size(node.snapshot.encoded)
            if size not in (None, (rig.width, rig.height)):
                raise ValueError(f"the view of node {k} is {size} pixels, its rig says {(rig.width, rig.height)}")


def _must(holds: bool, what: str) -> None:
    if not holds:
        raise ValueError(f"expected {what}")
