"""The summary of a run: the keys of `summary.json`, its file and its rows for a terminal."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.records import Estimate, MountLean
from topomap.core.run_data import RunData
from topomap.evaluation.closures import count
from topomap.evaluation.journey import home, legs
from topomap.evaluation.summary_table import Summary, table_rows
from topomap.evaluation.trajectory import ate, travel

__all__ = ["Summary", "plain", "summarise", "table_rows", "write_summary", "write_whole"]


def summarise(run: RunData) -> Summary:
    """Return the summary of a run: plain JSON values, null where something doesn't apply.

    A calibration value that the data doesn't show has found null and keeps its sigma. A replay's home members
    are all null. distance_m is the true path length, or the odometry's where the truth is unknown.
    """
    estimated, true = run.calibration, run.true_calibration
    return {
        "world": run.world,
        "seed": run.seed,
        "config": plain(run.config),
        "distance_m": _number(_distance(run)),
        "steps": len(run.stamps_ns),
        "steps_per_s": _number(run.steps_per_s),
        "snapshots": sum(node.snapshot for node in run.nodes),
        "closures": _closures(run),
        "dead_reckoning_ate_m": _ates(run, run.dead_reckoning),
        "map_ate_m": _ates(run, run.final),
        "online_ate_m": _ates(run, run.online),
        "rotation_scale": _scale(true.rotation_scale, estimated.rotation_scale if estimated else None),
        "distance_scale": _scale(true.distance_scale, estimated.distance_scale if estimated else None),
        "curvature": _scale(true.curvature, estimated.curvature if estimated else None),
        "home": _home(run),
        "legs": _legs(run),
        "trust": {
            "kept": run.trust.kept or None,
            "way_noise": _number(run.trust.way_noise),
            "turn_noise": _number(run.trust.turn_noise),
        },
        "mount": _mount(run.mount),
        "graph_hash": run.graph_hash,
        "topology_hash": run.topology_hash,
        "fault": run.fault or None,
        "log": {"state": run.log_state, "note": run.log_note or None},
        "versions": plain(run.versions),
    }


def _closures(run: RunData) -> Summary:
    closures = count(run)
    return {
        "proposed": closures.proposed,
        "accepted": closures.accepted,
        "false": closures.false,
        "gross": closures.gross,
        "possible": closures.possible,
        "recall": _number(closures.recall),
        "false_ever": closures.false_ever,
        "recall_standing": _number(closures.recall_standing),
    }


def _home(run: RunData) -> Summary:
    way = home(run)
    return {
        "asked": way.asked,
        "claimed": way.claimed,
        "within_0_3_m": way.within,
        "error_m": _number(way.error),
        "path_ratio": _number(way.path_ratio),
        "shortest_ratio": _number(way.shortest_ratio),
        "collisions": way.collisions,
    }


def _legs(run: RunData) -> list[Summary]:
    return [
        {
            "goal": leg.goal,
            "claimed": leg.claimed,
            "within_0_3_m": leg.within,
            "error_m": _number(leg.error),
            "way_m": _number(leg.way),
            "path_ratio": _number(leg.ratio),
            "collisions": leg.collisions,
        }
        for leg in legs(run)
    ]


def plain(value: object) -> object:
    """Return a value as JSON knows it: numbers that aren't finite are null, what has no JSON form is text."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return _number(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset | np.ndarray):
        return [plain(item) for item in (sorted(value) if isinstance(value, set | frozenset) else value)]
    return str(value)


def write_summary(path: Path, summary: Summary) -> None:
    """Write a summary as JSON, whole or not at all: a temporary file beside it is renamed over it.

    Raises OSError where the folder can't be written, ValueError for a number that JSON doesn't know.
    """
    text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(path, text)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write text or bytes to a file so that nobody ever sees half of it, not even after a power cut; raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with temporary.open("xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _distance(run: RunData) -> float:
    known = run.truth is not None and bool(np.isfinite(run.truth[:, :2]).all())
    path = travel(run.truth if known and run.truth is not None else run.dead_reckoning)
    return float(path[-1]) if len(path) else 0.0


def _ates(run: RunData, estimate: FloatArray) -> Summary:
    if run.truth is None:
        return {"se2": None, "sim2": None}
    return {
        "se2": _number(ate(estimate, run.truth)),
        "sim2": _number(ate(estimate, run.truth, scale=True)),
    }


def _scale(true: float | None, estimated: Estimate | None) -> Summary:
    found = estimated.value if estimated is not None and estimated.observed else None
    sigma = estimated.sigma if estimated is not None else None
    return {"true": _number(true), "found": _number(found), "sigma": _number(sigma)}


def _mount(mount: MountLean | None) -> Summary:
    """Say in degrees how the camera leans: all null where too little was seen."""
    angles = (None,) * 4 if mount is None else (mount.roll, mount.pitch, mount.sigma, mount.sway)
    names = ("roll_deg", "pitch_deg", "sigma_deg", "sway_deg")
    said: Summary = {
        name: None if a is None else _number(math.degrees(a)) for name, a in zip(names, angles, strict=True)
    }
    return said | {"taken_out": None if mount is None else mount.taken_out}


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
