"""The ledger of closures as rows of text: verdict, reason, scores and what the truth says."""

from __future__ import annotations

import math
from dataclasses import dataclass

from topomap.core.records import Verdict
from topomap.core.run_data import RunData
from topomap.evaluation.closures import Closure, Judgement

MISSING = "–"


@dataclass(frozen=True, slots=True)
class LedgerRow:
    """One candidate in words: time [s] of the query, match node, last verdict, whether true, how far off, the
    reason, the scores and the verdicts that came before."""

    time: str
    query: str
    match: str
    verdict: str
    truth: str
    off: str
    similarity: str
    scores: str
    reason: str
    before: str


def ledger(run: RunData, every: tuple[Closure, ...], verdicts: tuple[Verdict, ...]) -> list[LedgerRow]:
    """Return those of every closure whose last verdict is one of these, by time of the query."""
    chosen = [closure for closure in every if closure.verdict in verdicts]
    chosen.sort(key=lambda closure: (closure.candidate.query_ns, closure.candidate.match))
    return [_row(run, closure) for closure in chosen]


def _row(run: RunData, closure: Closure) -> LedgerRow:
    candidate = closure.candidate
    return LedgerRow(
        time=f"{(candidate.query_ns - int(run.stamps_ns[0])) * 1e-9:.1f}",
        query=MISSING if candidate.query is None else str(candidate.query),
        match=str(candidate.match),
        verdict=str(closure.verdict),
        truth=_truth(closure.judgement),
        off=_off(closure.judgement),
        similarity=f"{candidate.similarity:.3f}",
        scores=", ".join(f"{name} {value:.3g}" for name, value in candidate.evidence.measured().items()),
        reason=closure.reason,
        before=", then ".join(f"{d.verdict}: {d.reason}" for d in closure.decisions[:-1]),
    )


def _truth(judgement: Judgement | None) -> str:
    if judgement is None:
        return MISSING
    return "gross" if judgement.gross else "false" if judgement.false else "true"


def _off(judgement: Judgement | None) -> str:
    if judgement is None:
        return MISSING
    turn = judgement.rotation_error
    return f"{judgement.distance:.2f} m" + ("" if turn is None else f", {math.degrees(turn):+.1f}°")
