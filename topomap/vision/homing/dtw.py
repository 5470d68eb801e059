"""H26, H27, H28: home vectors from columns matched by dynamic time warping (chapter 5.1.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.ring import RING, RingSpec, ring
from topomap.vision.matching.inhibition import Inhibition, inhibited
from topomap.vision.matching.kernels import dtw_pairs, dtw_path
from topomap.vision.matching.ring_flow import FLOW, FlowSpec, fitted_flow


@dataclass(frozen=True, slots=True)
class RingPair:
    """What the method keeps of a panorama: fine (F, C) for matching, coarse (F, C') for the flow, and the
    bearing [rad] of fine's column 0.
    """

    fine: Float32Array
    coarse: Float32Array
    first_bearing: float


@dataclass(frozen=True, slots=True)
class Match:
    """A home vector with the cost of the matching: 0 same, about 1 (the mirrored goal's) unrelated."""

    home: HomeVector
    cost: float


@dataclass(frozen=True, slots=True)
class DynamicWarping:
    """sum over home bearings of [u(matched current bearing) - u(home bearing)] (5.15, 5.16, whose printed
    sign is reversed); bearing only; needs aligned views.

    wings: "unifying" matches once around from the diffusion point (H27), "wing" each side from the diffusion
    to the convergence point (H26); band [rad]: Sakoe-Chiba's, how far a column may move. inhibition (H28; 5.1.3.8):
    "mean" averages a home column's partners, "none" counts every pair, "target" keeps a home column's most alike
    partner, "reverse" a current one's, "both" either. swing [rad]: tries the current view turned by so much either
    way as well and keeps the match of least cost (5.1.3.4).
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    wings: Literal["unifying", "wing"] = "unifying"
    spec: RingSpec = RING
    flow: FlowSpec = FLOW
    flow_columns: int = 180
    band: float = math.radians(50.0)
    inhibition: Inhibition = "mean"
    swing: float = 0.0

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        if self.swing:
            return Origin("H28", "5.1.3.4")
        if self.inhibition != "mean":
            return Origin("H28", "5.1.3.8")
        return Origin("H27", "5.16") if self.wings == "unifying" else Origin("H26", "5.15")

    def describe(self, panorama: Panorama) -> RingPair:
        """Return the rings the matching runs on."""
        spec = self.spec
        coarse = RingSpec(self.flow_columns, spec.bands, spec.top, spec.bottom, spec.blur, spec.colour)
        fine = ring(panorama, spec)
        first_bearing = 0.5 * (TAU / fine.shape[1] - TAU / panorama.rig.width)
        return RingPair(fine, ring(panorama, coarse), first_bearing)

    def home(self, current: RingPair, goal: RingPair) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame."""
        return self.match(current, goal).home

    def match(self, current: RingPair, goal: RingPair) -> Match:
        """Return the home vector and the cost of the matching, to verify that two views show one place.

        Raises ShapeError.
        """
        if current.fine.shape != goal.fine.shape:
            raise ShapeError(f"rings differ in shape: {current.fine.shape} and {goal.fine.shape}")
        if goal.fine.shape[1] < 5:
            return Match(HomeVector(0.0, None, 0.0), 1.0)
        turns = (0.0, -self.swing, self.swing) if self.swing > 0.0 else (0.0,)
        return min((self._turned(current, goal, turn) for turn in turns), key=lambda match: match.cost)

    def _turned(self, current: RingPair, goal: RingPair, turn: float) -> Match:
        """Match with the current view rolled by `turn` [rad], and turn the bearing back."""
        if turn:
            rolled = (np.roll(r, round(turn * r.shape[1] / TAU), axis=1) for r in (current.fine, current.coarse))
            current = RingPair(next(rolled), next(rolled), current.first_bearing)
            found = self._match(current, goal)
            home = HomeVector(wrap(found.home.bearing - turn), None, found.home.confidence)
            return Match(home, found.cost)
        return self._match(current, goal)

    def _match(self, current: RingPair, goal: RingPair) -> Match:
        ahead = fitted_flow(current.coarse, goal.coarse, self.flow).direction
        start = round(ahead * goal.fine.shape[1] / TAU)
        pairs, cost = self._matched(current.fine, goal.fine, start)
        first = start * TAU / goal.fine.shape[1] + goal.first_bearing
        _, mirrored = self._matched(current.fine, np.ascontiguousarray(goal.fine[:, ::-1]), start)
        relative = cost / mirrored if mirrored > 1e-9 else 1.0
        return Match(matched_home(pairs[0] + first, pairs[1] + first, relative), relative)

    def _matched(self, current: Float32Array, goal: Float32Array, start: int) -> tuple[FloatArray, float]:
        """Return matched goal and current bearings from column `start` on, (2, M) [rad], and the mean cost."""
        columns = goal.shape[1]
        band = min(max(round(self.band * columns / TAU), 1), columns - 1)
        here, there = np.roll(current, -start, axis=1), np.roll(goal, -start, axis=1)
        if self.wings == "unifying":
            pairs, cost = self._paired(there, here, band)
            return pairs * (TAU / columns), cost
        half = columns // 2
        pieces = [self._paired(_piece(there, k, half), _piece(here, k, half), min(band, half - 1)) for k in (0, 1)]
        joined = np.concatenate([pieces[0][0], pieces[1][0] + half], axis=1)
        return joined * (TAU / columns), (pieces[0][1] + pieces[1][1]) / 2

    def _paired(self, there: Float32Array, here: Float32Array, band: int) -> tuple[FloatArray, float]:
        if self.inhibition == "mean":
            shift, cost = dtw_path(there, here, band)
            own = np.arange(len(shift), dtype=np.float64)
            return np.stack([own, own + shift]), cost
        goal, current, unlike, cost = dtw_pairs(there, here, band)
        kept = inhibited(goal, current, unlike, self.inhibition)
        return np.stack([goal[kept], current[kept]]).astype(np.float64), cost


def _piece(rings: Float32Array, k: int, half: int) -> Float32Array:
    return np.ascontiguousarray(rings[:, :half] if k == 0 else rings[:, half:])


def matched_home(there: FloatArray, here: FloatArray, cost: float) -> HomeVector:
    """Return the home vector (5.15, 5.16) of matched goal and current bearings (M,) [rad]; cost: as in `Match`."""
    x = float(np.sum(np.cos(here) - np.cos(there))) / len(there)
    y = float(np.sum(np.sin(here) - np.sin(there))) / len(there)
    sure = min(max(1.0 - cost, 0.0), 1.0) if math.hypot(x, y) > 1e-6 else 0.0
    return HomeVector(math.atan2(y, x), None, sure)
