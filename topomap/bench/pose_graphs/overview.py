"""All that is kept of the injection test in a line a graph and kind: each contestant's worst over shares and seeds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from topomap.bench.pose_graphs.bench import NONE, OURS, Row

BESIDE = "DCS"  # the peer that times are compared with


def overview(rows: Sequence[Row]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return headings and lines: of each contestant the least precision and recall and the largest ATE [m], how often
    it was stopped, and the mean times on the processor [s] of ours and of DCS, where it wasn't.
    """
    methods = [OURS, *dict.fromkeys(row.method for row in rows if row.method != OURS)]
    times = f"CPU [s], {OURS} / {BESIDE}"
    headings = ("graph", "false ones", "share", "runs", "odometry [m]", *methods, times)
    return headings, [_line(own, methods) for own in _groups(rows)]


def _groups(rows: Sequence[Row]) -> Iterable[list[Row]]:
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.graph, row.kind), []).append(row)
    return groups.values()


def _line(own: list[Row], methods: Sequence[str]) -> tuple[str, ...]:
    shares = sorted({row.false_share for row in own})
    of = {method: [row for row in own if row.method == method] for method in methods}
    return (
        own[0].graph,
        own[0].kind,
        "0" if own[0].kind == NONE else f"{shares[0]:.0%}-{shares[-1]:.0%}" if len(shares) > 1 else f"{shares[0]:.0%}",
        str(len(of[OURS])),
        f"{own[0].odometry_ate_m:.2f}",
        *(_worst(of[method]) for method in methods),
        f"{_time(of[OURS])} / {_time(of.get(BESIDE, []))}",
    )


def _worst(own: list[Row]) -> str:
    """Return a method's least precision and recall and its largest ATE, and how often it was stopped."""
    if not own:
        return "not run"
    stopped = sum(row.stopped for row in own)
    ended = [row for row in own if not row.stopped]
    precisions = [row.precision for row in ended if row.precision is not None]
    recalls = [row.recall for row in ended if row.recall is not None]
    ates = [row.ate_m for row in ended if row.ate_m is not None]
    told = [f"{min(precisions):.4f}" if precisions else "-", f"{min(recalls):.3f}" if recalls else "-",
            f"{max(ates):.3f}" if ates else "-"]  # fmt: skip
    words = " / ".join(told) if ended else ""
    again = sum(not row.asked for row in own)
    told_stopped = f"{stopped} of {len(own)} stopped" + (f" ({again} not asked again)" if again else "")
    return ", ".join(part for part in (words, told_stopped if stopped else "") if part)


def _time(own: list[Row]) -> str:
    ended = [row.cpu_seconds for row in own if not row.stopped]
    return f"{np.mean(ended):.2f}" if ended else "-"
