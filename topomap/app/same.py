"""How near a replay's map is to that of the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from topomap.core.geometry import wrap_all
from topomap.core.run_data import RunData
from topomap.recording.run_reader import read_run


def compare(log: Path, replayed: Path) -> str:
    """Return a sentence on a replay's map beside the run's, nothing where the log was cut off before it had one.

    Raises DataError.
    """
    then, now = read_run(log), read_run(replayed)
    if not then.graph_hash:
        return ""
    if then.graph_hash == now.graph_hash:
        return "The graph hash is the run's."
    if not same_topology(then, now):
        return "The graph hash differs from the run's: the map has other nodes, edges or verdicts."
    metres, radians = distance(then, now)
    return (
        f"The topology is the run's; its poses are the same to {metres:.1g} m and {radians:.1g} rad, as another machine"
        " or version rounds."
    )


def same_topology(then: RunData, now: RunData) -> bool:
    """Return whether two runs' maps are the same but for numbers; logs before 0.2 have no hash of it, but the map."""
    if then.topology_hash and now.topology_hash:
        return then.topology_hash == now.topology_hash
    return _map(then) == _map(now)


def distance(then: RunData, now: RunData) -> tuple[float, float]:
    """Return by how much the poses of two maps of one topology differ at most [m, rad]."""
    if not then.nodes:
        return 0.0, 0.0
    apart = np.array([one.pose for one in then.nodes]) - np.array([one.pose for one in now.nodes])
    return float(np.hypot(apart[:, 0], apart[:, 1]).max()), float(np.abs(wrap_all(apart[:, 2])).max())


def _map(run: RunData) -> tuple[object, ...]:
    nodes = [(one.node, one.stamp_ns, one.snapshot) for one in run.nodes]
    said = [(one.candidate.query_ns, one.candidate.match, one.verdict) for one in run.decisions]
    return nodes, list(run.edges), said
