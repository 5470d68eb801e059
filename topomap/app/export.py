"""Runs in the formats other tools read: TUM trajectories and g2o pose graphs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.run_data import RunData
from topomap.evaluation.summary import write_whole
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map
from topomap.mapping.odometry.increments import integrate
from topomap.recording.run_reader import load_run


def export_run(log: Path, out: Path, tum: bool, g2o: bool) -> list[Path]:
    """Write what was asked for into a folder; return the files. Raises DataError.

    The g2o graph is made of the finished map, which lies beside the log.
    """
    written = write_tum(load_run(log), out) if tum else []
    if g2o:
        written += _write(out, {"map.g2o": g2o_text(load_map(log.with_suffix(".topomap")))})
    return written


def write_tum(run: RunData, out: Path) -> list[Path]:
    """Write the run's trajectories into a folder as TUM files; return them. Raises DataError."""
    return _write(out, {f"{name}.tum": tum_text(run.stamps_ns, poses) for name, poses in trajectories(run).items()})


def _write(out: Path, texts: dict[str, str]) -> list[Path]:
    try:
        for name, text in texts.items():
            write_whole(out / name, text)
    except OSError as error:
        raise DataError(f"{out}: can't be written ({error.strerror})") from error
    return [out / name for name in texts]


def trajectories(run: RunData) -> dict[str, FloatArray]:
    """Return the run's trajectories (N, 3) by name."""
    known = {"map": run.final, "online": run.online, "dead_reckoning": run.dead_reckoning}
    return known if run.truth is None else known | {"truth": run.truth}


def tum_text(stamps_ns: IntArray, poses: FloatArray) -> str:
    """Return `t tx ty tz qx qy qz qw` lines of stamps (N,) and poses (N, 3); rows with NaN are left out."""
    rows = []
    for stamp, (x, y, heading) in zip(stamps_ns.tolist(), poses.tolist(), strict=True):
        if math.isfinite(x) and math.isfinite(y):
            half = heading / 2 if math.isfinite(heading) else 0.0
            second, rest = divmod(stamp, 10**9)
            rows.append(f"{second}.{rest:09d} {x:.9f} {y:.9f} 0 0 0 {math.sin(half):.9f} {math.cos(half):.9f}\n")
    return "".join(rows)


def g2o_text(topo: TopoMap) -> str:
    """Return the map as g2o: VERTEX_SE2, and EDGE_SE2 with calibrated odometry and closures, node 0 fixed."""
    rows = [f"VERTEX_SE2 {i} {x!r} {y!r} {heading!r}" for i, (x, y, heading) in enumerate(topo.poses.tolist())]
    for a, b, increments in topo.odometry_edges():
        delta, covariance, _ = integrate(increments, topo.calibration)
        rows.append(_edge(a, b, delta, covariance))
    for closure in topo.closures:
        rows.append(_edge(closure.i, closure.j, closure.relative.array(), closure.covariance))
    return "\n".join([*rows, "FIX 0", ""])


def _edge(a: int, b: int, delta: FloatArray, covariance: FloatArray) -> str:
    # a parked robot's edge has no variance at all
    information = np.linalg.inv(covariance + 1e-12 * np.eye(3))
    upper = information[np.triu_indices(3)].tolist()
    return " ".join(["EDGE_SE2", str(a), str(b), *map(repr, delta.tolist()), *map(repr, upper)])
