"""Which way the columns run and where the nose is: the picture's roll and flow against the odometry."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.core.robot import Reading
from topomap.navigation.robot_check.finding import Finding, Findings, Readings

COLUMNS, ROWS = 360, 12
"""A picture is made this small first: a degree a column tells 180 degrees from 0 well enough."""
ENOUGH_TURN = math.radians(40)
"""[rad] that the odometry must have turned in its quick steps before it is held against the picture."""
QUICK = 0.5
"""Share of the greatest turn from which on a step counts as turning: straight past a near wall the picture rolls too,
by up to 8 degrees a step in sim2d's corridors."""
AGREE = 0.8
"""Correlation of roll and odometry turn from which on their ratio means something; sim2d's robots are above 0.99."""
FLOW = 8
"""[columns] by which the flow of a step is searched to either side."""
SECTOR = 20
"""[columns] that are matched together."""
STRAIGHT = math.radians(2)
"""[rad] of roll up to which a step counts as straight on."""
ASIDE = math.radians(50)
"""[rad] off the nose that the flow must come out of before forward_column is called wrong: near things on one side
pull it by up to 20 degrees in sim2d's rooms."""


@dataclass(frozen=True, slots=True)
class Roll:
    """How two series of turns belong together: ratio of the seen to the read turn, correlation, turn read [rad]."""

    ratio: float
    agreement: float
    turned: float


def check_directions(seen: Readings, found: Findings) -> Findings:
    """Find columns that run the other way, a nose elsewhere, turns in degrees or counted clockwise, ranges reversed.

    found: what other checks found; a field that is wrong already is not told twice.
    """
    told = {one.field for one in found}
    if "motion.turn" in told:
        return []
    views = [_small(reading) for reading in seen]
    turns = np.array([reading.motion.turn for reading in seen[1:]])
    rolls = np.array([_roll(a, b) for a, b in pairwise(views)])
    wrong = _turning(seen, turns, rolls, "ranges" in told)
    return wrong or _nose(seen, views, rolls)


def _turning(seen: Readings, turns: FloatArray, rolls: FloatArray, blind: bool) -> Findings:
    """Return what the picture's roll, and the ranges' where there are any, say about columns and turns."""
    roll = _compared(rolls, turns)
    if roll.turned < ENOUGH_TURN:
        text = f"says that the robot hardly turned in {len(seen)} readings, so which way columns run can't be told"
        return [Finding("motion.turn", f"{text}: turn it, take more readings or ask for drive=True")]
    if abs(roll.agreement) < AGREE:
        return [Finding("motion.turn", "doesn't follow the picture: it turns when the odometry doesn't, or otherwise")]
    scan = _scan_roll(seen, turns) if not blind else None
    same = None if scan is None or not 0.5 < abs(scan / roll.ratio) < 2.0 else scan / roll.ratio > 0
    if abs(roll.ratio) < 0.03:
        return [Finding("motion.turn", f"is {1 / abs(roll.ratio):.0f} times the picture's turn: degrees, not radians?")]
    if roll.ratio < 0 and same:
        return [Finding("motion.turn", "counts clockwise: picture and ranges turn the other way; left is positive")]
    if roll.ratio < 0:
        return [Finding("rig.clockwise", f"is {seen[0].rig.clockwise}, the picture rolls the other way")]
    if same is False:
        return [Finding("ranges", "run clockwise, they must run counter-clockwise from the nose")]
    if not 0.5 < roll.ratio < 2.0:
        return [Finding("motion.turn", f"is {1 / roll.ratio:.2f} times what the picture turns by")]
    return []


def _compared(rolls: FloatArray, turns: FloatArray) -> Roll:
    """Return how rolls (K,) and the odometry's turns (K,) belong together in the steps that turn quickly."""
    quick = np.abs(turns) >= QUICK * np.abs(turns).max(initial=0.0)
    rolls, turns = rolls[quick], turns[quick]
    power = float(np.square(turns).sum())
    both = float((rolls * turns).sum())
    scale = math.sqrt(power * float(np.square(rolls).sum()))
    return Roll(both / power if power else 0.0, both / scale if scale else 0.0, float(np.abs(turns).sum()))


def _scan_roll(seen: Readings, turns: FloatArray) -> float | None:
    """Return the ranges' turn as a share of the odometry's, None where they say nothing clear."""
    scans = [_scan(reading) for reading in seen]
    pairs = [(a, b, t) for a, b, t in zip(scans, scans[1:], turns, strict=False) if a is not None and b is not None]
    if not pairs:
        return None
    roll = _compared(np.array([_roll(a, b) for a, b, _ in pairs]), np.array([t for _, _, t in pairs]))
    return roll.ratio if abs(roll.agreement) >= AGREE else None


def _scan(reading: Reading) -> Float32Array | None:
    """Return the nearness (1, COLUMNS) around, nothing where nothing was measured; None without ranges."""
    if reading.ranges is None or not np.isfinite(reading.ranges).any():
        return None
    near = np.nan_to_num(1.0 / reading.ranges, nan=0.0).astype(np.float32)[None]
    return _centred(cv2.resize(near, (COLUMNS, 1), interpolation=cv2.INTER_AREA).reshape(1, COLUMNS))


def _small(reading: Reading) -> Float32Array:
    """Return the view (rows, COLUMNS) in grey, counter-clockwise from the nose as the rig says, rows of mean 0."""
    rig = reading.rig
    grey = cv2.cvtColor(np.ascontiguousarray(reading.image), cv2.COLOR_RGB2GRAY).astype(np.float32)
    ordered = grey[:, ::-1] if rig.clockwise else grey
    nose = rig.width - 1 - rig.forward_column if rig.clockwise else rig.forward_column
    rolled = np.roll(ordered, -nose, axis=1)
    small = cv2.resize(rolled, (COLUMNS, min(ROWS, rig.height)), interpolation=cv2.INTER_AREA)
    return _centred(small.astype(np.float32))


def _centred(view: Float32Array) -> Float32Array:
    blurred = cv2.GaussianBlur(cv2.copyMakeBorder(view, 0, 0, 8, 8, cv2.BORDER_WRAP), (0, 0), 1.0)[:, 8:-8]
    centred: Float32Array = (blurred - blurred.mean(axis=1, keepdims=True)).astype(np.float32)
    return centred


def _roll(before: Float32Array, after: Float32Array) -> float:
    """Return how far left the robot turned between two views [rad], to a fraction of a column."""
    spectra = np.fft.rfft(before, axis=1) * np.conj(np.fft.rfft(after, axis=1))
    overlap = np.fft.irfft(spectra.sum(axis=0), COLUMNS)
    best = int(overlap.argmax())
    left, middle, right = (float(overlap[(best + k) % COLUMNS]) for k in (-1, 0, 1))
    bend = left - 2 * middle + right
    shift = best + (0.5 * (left - right) / bend if bend else 0.0)
    return math.remainder(shift * TAU / COLUMNS, TAU)


def _nose(seen: Readings, views: list[Float32Array], rolls: FloatArray) -> Findings:
    """Return whether the view flows out of another column than the nose's while the robot rolls straight on.

    Things at bearing b move by v = s sin(b - nose)/distance: v is fitted by a constant, a cosine and a sine.
    """
    ways = np.array([reading.motion.forward for reading in seen[1:]])
    straight = (np.abs(rolls) < STRAIGHT) & (np.abs(ways) > 0.3 * np.abs(ways).max(initial=0.0)) & (ways != 0)
    if straight.sum() < 5:
        return []
    flow = np.mean([_flow(views[k], views[k + 1]) * np.sign(ways[k]) for k in np.flatnonzero(straight)], axis=0)
    bearings = np.arange(COLUMNS) * TAU / COLUMNS
    cosine, sine = float((flow * np.cos(bearings)).sum()), float((flow * np.sin(bearings)).sum())
    nose = math.atan2(-cosine, sine)
    explained = (cosine**2 + sine**2) * 2 / COLUMNS
    if abs(nose) < ASIDE or explained < 0.3 * float(np.square(flow - flow.mean()).sum()):
        return []
    rig = seen[0].rig
    columns = round(nose * rig.width / TAU) * (-1 if rig.clockwise else 1)
    text = f"is {rig.forward_column}, going forward the view comes out of about column"
    return [Finding("rig.forward_column", f"{text} {(rig.forward_column + columns) % rig.width}")]


def _flow(before: Float32Array, after: Float32Array) -> FloatArray:
    """Return by how many columns (COLUMNS,) what is around each column moved counter-clockwise."""
    costs = []
    for shift in range(-FLOW, FLOW + 1):
        squares = np.square(np.roll(before, shift, axis=1) - after).sum(axis=0)
        wrapped = np.concatenate([squares[-SECTOR:], squares, squares[:SECTOR]])
        sums = np.convolve(wrapped, np.ones(2 * SECTOR + 1), "valid")
        costs.append(sums)
    moved: FloatArray = np.argmin(costs, axis=0).astype(np.float64) - FLOW
    return moved
