"""What the engine must reach in the injection test, and the cells where it falls short."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from topomap.bench.pose_graphs.bench import OURS
from topomap.bench.pose_graphs.table import Cell

PRECISION = 0.999  # in every cell, least over the seeds
RECALL = 0.98  # of the best peer's that is as precise
ATE, ATE_FLOOR = 1.2, 0.05  # times the best of all contestants', odometry too, or so many metres
TIE = 1e-6  # [m]: an optimum found again isn't above itself


def shortfalls(cells: Sequence[Cell]) -> list[str]:
    """Return a line a target that is missed: graph, kind, share and by how much."""
    lines = []
    for own in cells:
        if own.method == OURS:
            peers = [cell for cell in cells if cell.method != OURS and _of(cell) == _of(own)]
            lines += [f"{own.graph}, {own.kind}, {own.false_share:.0%}: {what}" for what in _missed(own, peers)]
    return lines


def _of(cell: Cell) -> tuple[str, str, float]:
    return cell.graph, cell.kind, cell.false_share


def _missed(own: Cell, peers: Sequence[Cell]) -> Iterator[str]:
    if own.precision_min is not None and own.precision_min < PRECISION:
        yield f"precision {own.precision_min:.4f} < {PRECISION} ({own.kept_false_max} false kept)"
    precise = [(peer.recall_mean, peer.method) for peer in peers
               if peer.recall_mean is not None and peer.precision_min is not None
               and peer.precision_min >= PRECISION]  # fmt: skip
    best, who = max(precise, default=(0.0, ""))
    if (own.recall_mean or 0.0) < RECALL * best:
        yield f"recall {own.recall_mean or 0.0:.3f} < {RECALL} x {best:.3f} ({who})"
    if own.ate_m_max is None or own.ate_m_mean is None:
        yield "no poses"
        return
    if own.ate_m_max > own.odometry_ate_m + TIE:
        yield f"ATE {own.ate_m_max:.3f} m > odometry's {own.odometry_ate_m:.3f} m"
    contestants = [(peer.ate_m_mean, peer.method) for peer in peers if peer.ate_m_mean is not None and not peer.stopped]
    least, who = min([*contestants, (own.odometry_ate_m, "odometry")])
    if own.ate_m_mean > max(ATE * least, ATE_FLOOR):
        yield f"ATE {own.ate_m_mean:.3f} m > {ATE} x {least:.3f} m ({who})"
