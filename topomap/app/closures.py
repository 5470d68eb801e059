"""The audit trail of closures: every candidate of a log, one explained, precision against the truth."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from logs.errors import LogError
from logs.reader import LogReader
from logs.replay import decoded
from topomap.core.arrays import FloatArray, Image
from topomap.core.errors import DataError, TopomapError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import Verdict
from topomap.core.run_data import RunData
from topomap.evaluation.closures import Closure, closures
from topomap.evaluation.ledger_rows import LedgerRow, ledger
from topomap.evaluation.precision_recall import Evaluation, evaluate
from topomap.evaluation.summary import write_whole
from topomap.recording.run_reader import read_run
from topomap.report.figures.explain import explanation
from topomap.report.figures.precision import precision_recall
from topomap.report.figures.style import png
from topomap.vision.image.compare import rms, signature

CURVE_STEPS = 120


@dataclass(frozen=True)
class Explanation:
    """One candidate: rows of name and value for people, and the figure that was written (None: no images)."""

    rows: list[tuple[str, str]]
    figure: Path | None


def read(path: Path) -> RunData:
    """Return a log's run. Raises DataError."""
    return read_run(path)


def lacking(run: RunData) -> str:
    """Return what the log of a run lacks, nothing where it is whole."""
    return "" if run.log_state == "whole" else f"{run.log_state}: {run.log_note}"


def table(run: RunData, verdict: Verdict | None = None, false: bool = False) -> list[LedgerRow]:
    """Return the candidates by time: those with a verdict, if given; only those that the truth calls false, if asked.

    Raises TopomapError where false ones are asked for and the truth isn't known.
    """
    if false and run.truth is None:
        raise TopomapError("which closures are false isn't known: the log holds no true poses")
    every = closures(run)
    if false:
        every = tuple(c for c in every if c.judgement is not None and c.judgement.false)
    return ledger(run, every, tuple(Verdict) if verdict is None else (verdict,))


def evaluation(run: RunData, out: Path) -> tuple[Evaluation, Path]:
    """Judge the candidates by the truth and write the precision-recall figure. Raises TopomapError."""
    found = evaluate(run)
    if found is None:
        raise TopomapError("nothing to evaluate: no candidate whose true poses are known")
    path = out / "precision-recall.png"
    _save(precision_recall(run), path)
    return found, path


def explain(log: Path, query: str, match: str, out: Path) -> Explanation:
    """Explain the candidate between `query` (a node, or its time as '41.5s') and node `match`.

    Raises DataError, and TopomapError where there is no such candidate.
    """
    run = read_run(log)
    closure = _find(run, query, match)
    lines = [*_lines(run, closure)]
    title = f"{_name(run, closure)}: {closure.verdict}"
    figure = _picture(log, closure, title, lines, out)
    return Explanation(lines, figure)


def _find(run: RunData, query: str, match: str) -> Closure:
    if not match.isdecimal():
        raise TopomapError(f"the match '{match}' is no node: give its number")
    found = [c for c in closures(run) if c.candidate.match == int(match) and _is(run, c, query)]
    if not found:
        raise TopomapError(f"no candidate between '{query}' and node {match}; 'topomap closures LOG' lists them")
    accepted = [c for c in found if c.verdict is Verdict.ACCEPTED]
    return (accepted or found)[-1]


def _is(run: RunData, closure: Closure, query: str) -> bool:
    if query.isdecimal():
        return closure.candidate.query == int(query)
    try:
        wanted = float(query.removesuffix("s"))
    except ValueError:
        raise TopomapError(f"the query '{query}' is neither a node (12) nor a time (41.5s)") from None
    return abs(_time(run, closure) - wanted) < 0.051


def _time(run: RunData, closure: Closure) -> float:
    return (closure.candidate.query_ns - int(run.stamps_ns[0])) * 1e-9


def _name(run: RunData, closure: Closure) -> str:
    node = "" if closure.candidate.query is None else f" (node {closure.candidate.query})"
    return f"{_time(run, closure):.1f}s{node} against node {closure.candidate.match}"


def _lines(run: RunData, closure: Closure) -> Iterator[tuple[str, str]]:
    candidate, judged = closure.candidate, closure.judgement
    yield "candidate", _name(run, closure)
    heading = math.degrees(candidate.relative.heading)
    yield "claim", f"query at ({candidate.relative.x:.2f}, {candidate.relative.y:.2f}) m, {heading:.1f} degrees"
    yield "similarity", f"{candidate.similarity:.3f}"
    for name, value in candidate.evidence.measured().items():
        yield f"score {name}", f"{value:.4g}"
    for name, value in _limits(run.config):
        yield f"limit {name}", f"{value:g}"
    if judged is not None:
        turned = "" if judged.rotation_error is None else f", {math.degrees(judged.rotation_error):.1f} degrees off"
        yield "truth", f"{'false' if judged.false else 'true'}: {judged.distance:.2f} m apart{turned}"
    for decision in closure.decisions:
        at = (decision.stamp_ns - int(run.stamps_ns[0])) * 1e-9
        yield f"at {at:.1f} s", f"{decision.verdict}: {decision.reason}"


def _limits(config: Mapping[str, object]) -> Iterator[tuple[str, float]]:
    """Yield the numbers of the settings named 'closing' and below, wherever the configuration keeps them."""
    for name, value in config.items():
        if isinstance(value, Mapping):
            yield from _numbers(value) if name == "closing" else _limits(value)


def _numbers(section: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, float]]:
    for name, value in section.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, f"{prefix}{name}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield prefix + name, float(value)


def _picture(log: Path, closure: Closure, title: str, lines: list[tuple[str, str]], out: Path) -> Path | None:
    views = _views(log, closure)
    if views is None:
        return None
    query, match = views
    claimed = closure.candidate.relative.heading
    aligned = query.rotated(claimed)
    shown = [("the match", _middle(match)), ("the query, turned as claimed", _middle(aligned))]
    text = [line for name, value in lines for line in textwrap.wrap(f"{name}: {value}", 125)]
    path = out / f"closure-{closure.candidate.query_ns}-{closure.candidate.match}.png"
    _save(explanation(title, shown, _curve(query, match), claimed, text), path)
    return path


def _views(log: Path, closure: Closure) -> tuple[Panorama, Panorama] | None:
    """Return the panoramas of query and match, None where the log doesn't hold both."""
    try:
        with LogReader(log, skip_damaged=True) as reader:
            stored = [reader.panorama(ns) for ns in (closure.candidate.query_ns, closure.candidate.match_ns)]
            rig = reader.header.rig
    except LogError as error:
        raise DataError(str(error)) from error
    if stored[0] is None or stored[1] is None:
        return None
    query, match = (Panorama.from_recorded(decoded(image), rig) for image in stored if image is not None)
    return query, match


def _middle(panorama: Panorama) -> Image:
    """Return the image as people read it: the nose in the middle, clockwise."""
    image = np.roll(panorama.image[:, ::-1], panorama.rig.width // 2, axis=1)
    return np.ascontiguousarray(image)


def _curve(query: Panorama, match: Panorama) -> FloatArray:
    rotations = np.linspace(-TAU / 2, TAU / 2, CURVE_STEPS, endpoint=False)
    goal = signature(match)
    return np.array([rotations, [rms(signature(query.rotated(float(angle))), goal) for angle in rotations]])


def _save(figure: object, path: Path) -> None:
    from matplotlib.figure import Figure

    assert isinstance(figure, Figure)
    try:
        write_whole(path, png(figure, 120))
    except OSError as error:
        raise DataError(f"{path}: can't be written ({error.strerror})") from error
