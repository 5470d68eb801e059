"""Saved maps: what they hold, their places, merged, pruned, and in the formats other programs read."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.app.export import g2o_text, nodes_text, tum_rows, write_texts
from topomap.core.errors import DataError
from topomap.evaluation.summary import write_whole
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map, save_map
from topomap.mapping.mapper import MapperSettings
from topomap.mapping.places.place_groups import group_places
from topomap.mapping.sessions.cross_claims import CrossClaims
from topomap.mapping.sessions.merge import Told, merge
from topomap.mapping.sessions.places import forget_place, name_place, span
from topomap.mapping.sessions.prune import prune
from topomap.recording.true_nodes import Truths, read_truths, truth_file, truths_text
from topomap.report.figures.saved_map import draw_map
from topomap.vision.registry import aligner

Rows = list[tuple[str, str]]


@dataclass(frozen=True)
class Written:
    """Rows for people and the files written."""

    rows: Rows
    files: tuple[Path, ...] = ()


def describe(path: Path) -> Rows:
    """Return what a map file holds, in rows. Raises DataError."""
    topo, size = load_map(path), path.stat().st_size
    snapshots = [node for node in topo.nodes if node.snapshot is not None]
    views = sum(len(node.snapshot.encoded) for node in snapshots if node.snapshot)
    way = float(sum(np.abs(ways.deltas[:, 0]).sum() for _, b, ways in topo.odometry_edges() if b not in topo.jumps))
    metres = way / topo.calibration.distance_scale
    found = topo.calibration
    extent = np.ptp(topo.poses[:, :2], axis=0)
    per = f", {size / 10 / metres:.1f} kB per 100 m" if metres > 1 else ""
    return [
        ("nodes", f"{len(topo.nodes)}, numbers {span(topo)}; {len(snapshots)} with a view"),
        ("drives", str(1 + len(topo.jumps)) + (" stretches" if topo.jumps else "")),
        ("way", f"{metres:.1f} m, {extent[0]:.1f} x {extent[1]:.1f} m"),
        ("closures", str(len(topo.closures))),
        ("views", f"{topo.view}, {views / max(len(snapshots), 1):.0f} bytes each"),
        ("file", f"{size / 1000:.1f} kB{per}"),
        ("rotation scale", f"{found.rotation_scale:.4f}"),
        ("distance scale", f"{found.distance_scale:.4f}"),
        ("curvature", f"{found.curvature:.5f} rad/m"),
        ("journeys", f"{sum(e.passed for e in topo.experience)} edges passed, "
                     f"{sum(e.failed for e in topo.experience)} failed"),
        ("places", ", ".join(f"{name} = {node}" for name, node in sorted(topo.places.items())) or "none"),
    ]  # fmt: skip


def places(path: Path, add: list[str], remove: list[str]) -> Rows:
    """Name places of a map file and take names away; return those that there are. Raises DataError, TopomapError."""
    topo = load_map(path)
    for name in remove:
        forget_place(topo, name)
    for word in add:
        name_place(topo, word)
    if add or remove:
        save_map(topo, path)
    return [(name, f"node {node}{_position(topo, node)}") for name, node in sorted(topo.places.items())]


def groups(path: Path) -> Rows:
    """Return a map's places as groups of snapshots that look alike and lie together. Raises DataError."""
    topo = load_map(path)
    found = group_places(topo)
    return [
        (f"place {k}", f"nodes {', '.join(str(topo.names[n]) for n in own)}{_position(topo, topo.names[own[0]])}")
        for k, own in enumerate(found.members)
    ]


def _position(topo: TopoMap, number: int) -> str:
    node = topo.node_named(number)
    return "" if node is None else f" at {topo.poses[node, 0]:.2f}, {topo.poses[node, 1]:.2f} m"


def prune_file(path: Path, out: Path, told: Callable[[float], None]) -> Written:
    """Write a map without the nodes that add nothing. Raises DataError."""
    before = load_map(path)
    pruned = prune(before, told)
    save_map(pruned.map, out)
    kept = set(pruned.map.names)
    files = _with_truths(out, {node: pose for node, pose in read_truths(truth_file(path)).items() if node in kept})
    rows = [
        ("nodes", f"{len(before.nodes)} before, {len(pruned.map.nodes)} after: {len(pruned.gone)} left out"),
        ("views", f"{_views(before)} before, {_views(pruned.map)} after"),
        ("closures", f"{len(before.closures)} before, {len(pruned.map.closures)} after"),
        ("file", f"{path.stat().st_size / 1000:.1f} kB before, {out.stat().st_size / 1000:.1f} kB after"),
    ]
    return Written(rows, files)


def merge_files(first: Path, second: Path, out: Path, told: Told) -> Written:
    """Write two maps as one, in the frame and with the numbers of the first. Raises DataError, TopomapError."""
    a, b = load_map(first), load_map(second)
    claims = CrossClaims(aligner("min-warping"), MapperSettings().closing.offset)
    merged = merge(a, b, claims, told)
    save_map(merged.map, out)
    mine, theirs = read_truths(truth_file(first)), read_truths(truth_file(second))
    both = {**mine, **{node + merged.offset: pose for node, pose in theirs.items()}} if mine and theirs else {}
    double = sorted(set(a.places) & set(b.places))
    rows = [
        ("nodes", f"{len(a.nodes)} + {len(b.nodes)}; node n of {second.name} is now node n + {merged.offset}"),
        ("between them", f"{merged.across} closures stand of {merged.proposed} proposed"),
        ("within them", f"{len(a.closures) + len(b.closures) - merged.lost} closures stand, {merged.lost} no longer"),
    ]
    if double:
        rows.append(("places", f"{', '.join(double)} are those of {first.name}"))
    return Written(rows, _with_truths(out, both))


def _with_truths(out: Path, truths: Truths) -> tuple[Path, ...]:
    """Write the true poses of a simulated map's nodes beside it, for metrics; return the files."""
    if not truths:
        truth_file(out).unlink(missing_ok=True)
        return (out,)
    write_whole(truth_file(out), truths_text(truths))
    return out, truth_file(out)


def _views(topo: TopoMap) -> int:
    return sum(node.snapshot is not None for node in topo.nodes)


def export_map(path: Path, out: Path) -> Written:
    """Write a map as g2o, TUM, JSON, GeoJSON and PNG into a folder. Raises DataError."""
    topo = load_map(path)
    stamps, poses = topo.trajectory()
    texts = {
        "map.json": json.dumps(as_json(topo), indent=1),
        "map.geojson": json.dumps(as_geojson(topo), indent=1),
        "map.tum": tum_rows(stamps, poses),
        "map-nodes.csv": nodes_text(topo),
    }
    if len(topo.nodes) > 1:
        texts["map.g2o"] = g2o_text(topo)
    files = write_texts(out, texts)
    picture = out / "map.png"
    try:
        draw_map(topo).savefig(picture)
    except OSError as error:
        raise DataError(f"{picture}: can't be written ({error.strerror})") from error
    return Written([], (*files, picture))


def as_json(topo: TopoMap) -> dict[str, object]:
    """Return nodes, edges and places by number, for programs: metres and radians in the map frame."""
    number = topo.names
    nodes = [
        {"node": number[k], "stamp_ns": node.stamp_ns, "x": x, "y": y, "heading": heading,
         "view": node.snapshot is not None}
        for k, (node, (x, y, heading)) in enumerate(zip(topo.nodes, topo.poses.tolist(), strict=True))
    ]  # fmt: skip
    edges = [{"a": number[a], "b": number[b], "kind": data["kind"]} for a, b, data in topo.graph.edges(data=True)]
    return {"frame": "map", "units": "m, rad, ns", "nodes": nodes, "edges": edges, "places": topo.places}


def as_geojson(topo: TopoMap) -> dict[str, object]:
    """Return the map as GeoJSON features whose coordinates are metres in the map frame, not degrees."""
    names: dict[int, list[str]] = {}
    for name, node in topo.places.items():
        names.setdefault(node, []).append(name)
    points = [
        _feature("Point", [x, y], {"node": topo.names[k], "heading": heading, "places": names.get(topo.names[k], []),
                                   "view": topo.nodes[k].snapshot is not None})
        for k, (x, y, heading) in enumerate(topo.poses.tolist())
    ]  # fmt: skip
    lines = [
        _feature("LineString", topo.poses[[a, b], :2].tolist(), {"kind": data["kind"]})
        for a, b, data in topo.graph.edges(data=True)
    ]
    return {"type": "FeatureCollection", "features": [*points, *lines]}


def _feature(kind: str, coordinates: object, properties: dict[str, object]) -> dict[str, object]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}
