"""A log as the arrays that summary and report are made of."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import TypeVar

import numpy as np

from logs import records as log
from logs import topics
from logs.errors import LogError
from logs.reader import Gathered, LogReader
from logs.replay import decoded
from topomap.core.arrays import FloatArray, Image
from topomap.core.errors import DataError
from topomap.core.records import CalibrationState, Decision, MountLean, Phase, Verdict
from topomap.core.run_data import NodeData, RunData, Trust
from topomap.recording import decode
from topomap.recording import steps as columns
from topomap.recording.legs import legs
from topomap.recording.steps import Steps, read_steps
from topomap.recording.true_nodes import ATTACHMENT, parse_truths

R = TypeVar("R")

TOPICS = (
    *columns.TOPICS,
    topics.CLOSURES,
    topics.NODE,
    topics.CALIBRATION,
    topics.FINAL,
    topics.PERFORMANCE,
)
FARTHEST = 1e13  # [m], [rad] what an odometer may count (`Track.check`) in a million steps
BEFORE = (20, 10)  # steps before the first closure whose panoramas are shown


class PartialLogWarning(UserWarning):
    """A log that was read isn't whole: it was cut off, damaged, repaired, or can't be verified."""


def load_run(path: Path | str) -> RunData:
    """Return a run from its log, whole or not; what isn't is a PartialLogWarning and in log_state and log_note.

    Where the run was cut off before its finished map was written, graph_hash is empty, there are no edges, and
    the final trajectory and the nodes' poses are those of the online estimate. Raises DataError with one
    line when the log can't be read or holds no whole step.
    """
    run = read_run(path)
    if run.log_state != "whole":
        warnings.warn(f"{path}: {run.log_state}: {run.log_note}", PartialLogWarning, stacklevel=2)
    return run


def read_run(path: Path | str) -> RunData:
    """Return a run from its log, as `load_run` does, without a warning.

    Where the run was cut off before its finished map was written, graph_hash is empty, there are no edges, and
    the final trajectory and the nodes' poses are those of the online estimate. Raises DataError with one
    line when the log can't be read or holds no whole step.
    """
    try:
        with LogReader(path, skip_damaged=True) as log_file:
            return _load(log_file)
    except LogError as error:
        text = str(error)
        raise DataError(text if str(path) in text else f"{path}: {text}") from error
    except (ValueError, TypeError, OverflowError, RecursionError, MemoryError) as error:
        # what is in the records is what somebody wrote: a verdict of another name, a matrix of other numbers
        raise DataError(f"{path}: holds values that no run writes ({type(error).__name__}: {error})") from error


def _load(log_file: LogReader) -> RunData:
    rows = log_file.gather(TOPICS)
    header, steps = log_file.header, read_steps(rows)
    if not len(steps.stamps_ns):
        raise LogError(f"{log_file.file.path}: holds no whole step")
    final = _last(rows, topics.FINAL, log.Final)
    closures = rows.records(topics.CLOSURES, log.Closure)
    decisions = tuple(decode.decision(stored) for _, stored in closures)
    performance = _last(rows, topics.PERFORMANCE, log.Performance)
    nodes = _nodes(rows, final)
    final_poses = _trajectory(steps, final)
    ways = legs(steps.missions)
    _check_poses(steps.dead_reckoning, steps.online, final_poses)
    return RunData(
        world=header.world,
        seed=header.seed,
        config=json.loads(header.config),
        versions=header.versions,
        stamps_ns=steps.stamps_ns,
        dead_reckoning=steps.dead_reckoning,
        online=steps.online,
        final=final_poses,
        truth=steps.truth,
        plan=decode.plan(header),
        driven=steps.driven,
        contact=steps.contact,
        difference=steps.difference("snapshot"),
        place_difference=steps.difference("place"),
        homing_difference=steps.difference("homing"),
        threshold=_threshold(steps),
        nodes=nodes,
        earlier=_earlier(log_file, nodes),
        edges=() if final is None else tuple((edge.a, edge.b, edge.kind) for edge in final.edges),
        decisions=decisions,
        calibration=_calibration(rows, final),
        true_calibration=decode.true_calibration(header),
        first_closure=_first_closure(log_file, steps, decisions),
        goal_node=_goal(steps, final),
        claimed=_claimed(steps, final),
        milestones=tuple(node for leg in ways for node in leg.milestones),
        legs=ways,
        replayed=header.replayed,
        graph_hash="" if final is None else final.graph_hash,
        trust=Trust() if final is None else Trust(final.kept or "", final.way_noise, final.turn_noise),
        mount=_mount(final),
        stage_ms=steps.stage_ms,
        steps_per_s=None if performance is None else performance.steps_per_s,
        topology_hash=(final and final.topology_hash) or "",
        fault=(final and final.fault) or "",
        log_state=log_file.state.word,
        log_note=log_file.state.note,
    )


def _check_poses(*routes: FloatArray) -> None:
    """Raise ValueError for poses (N, 3) that no robot can have."""
    for poses in routes:
        if not (np.abs(poses) < FARTHEST).all():  # nor where a number is none
            raise ValueError(f"poses that are no numbers or farther than {FARTHEST:g} m")


def _mount(final: log.Final | None) -> MountLean | None:
    if final is None or final.roll is None or final.pitch is None or final.lean_sigma is None:
        return None
    return MountLean(final.roll, final.pitch, final.lean_sigma, final.sway or 0.0, bool(final.taken_out))


def _last(rows: Gathered, topic: str, kind: type[R]) -> R | None:
    last: R | None = None
    for _, record in rows.records(topic, kind):
        last = record
    return last


def _trajectory(steps: Steps, final: log.Final | None) -> FloatArray:
    """Return the finished map's poses (N, 3) at the steps, the online estimate where it has none."""
    poses = steps.online.copy()
    if final is not None:
        rows = {stamp: row for row, stamp in enumerate(final.stamps_ns)}
        finished = np.array(final.poses, dtype=np.float64).reshape(-1, 3)
        for step, stamp in enumerate(steps.stamps_ns.tolist()):
            if stamp in rows:
                poses[step] = finished[rows[stamp]]
    return poses


def _nodes(rows: Gathered, final: log.Final | None) -> tuple[NodeData, ...]:
    stored = final.nodes if final else [node for _, node in rows.records(topics.NODE, log.Node)]
    return tuple(
        NodeData(node.node, node.stamp_ns, np.array([node.pose.x, node.pose.y, node.pose.heading]), node.snapshot)
        for node in stored
    )


def _earlier(log_file: LogReader, nodes: tuple[NodeData, ...]) -> dict[int, FloatArray]:
    """Return the true poses of the nodes that the run began with, by stamp."""
    content = log_file.attachment(ATTACHMENT)
    known = parse_truths(content.decode(), ATTACHMENT) if content else {}
    return {node.stamp_ns: np.array(known[node.node]) for node in nodes if node.node in known}


def _calibration(rows: Gathered, final: log.Final | None) -> CalibrationState | None:
    stored = final.calibration if final else _last(rows, topics.CALIBRATION, log.Calibration)
    return None if stored is None else decode.calibration(stored)


def _threshold(steps: Steps) -> float | None:
    values = steps.difference("threshold")
    known = values[np.isfinite(values)]
    return float(known[-1]) if len(known) else None


def _goal(steps: Steps, final: log.Final | None) -> int | None:
    if final is not None and final.goal_node is not None:
        return final.goal_node
    return next((mission.goal for mission in reversed(steps.missions) if mission.goal is not None), None)


def _claimed(steps: Steps, final: log.Final | None) -> bool | None:
    if final is not None:
        return final.claimed
    phases = {mission.travel for mission in steps.missions}
    return Phase.ARRIVED in phases if phases - {Phase.TEACH} else None


def _first_closure(log_file: LogReader, steps: Steps, decisions: tuple[Decision, ...]) -> tuple[tuple[str, Image], ...]:
    first = next((made for made in decisions if made.verdict is Verdict.ACCEPTED), None)
    if first is None:
        return ()
    candidate = first.candidate
    step = int(np.searchsorted(steps.stamps_ns, candidate.query_ns))
    wanted = [(f"{n} steps before", int(steps.stamps_ns[step - n])) for n in BEFORE if n <= step]
    wanted += [
        ("at the first closure", candidate.query_ns),
        (f"its match, node {candidate.match}", candidate.match_ns),
    ]
    images = [(label, log_file.panorama(stamp)) for label, stamp in wanted]
    return tuple((label, decoded(encoded)) for label, encoded in images if encoded)
