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
from topomap.vision.matching.dtw_kernels import dtw_pairs, dtw_path
from topomap.vision.matching.image_flow import GreyView, fitted_image_flow, grey_view
from topomap.vision.matching.inhibition import Inhibition, inhibited
from topomap.vision.matching.ring_flow import FLOW, FlowSpec, fitted_flow
from topomap.vision.matching.still import still

Start = Literal["ring", "image"]
Wings = Literal["unifying", "wing", "joined"]
VIEW = (360, 50)
"""Columns and rows of the small view whose flow shows the stationary points."""


@dataclass(frozen=True, slots=True)
class RingPair:
    """What the method keeps of a panorama: fine (F, C) for matching, coarse (F, C') for the flow, and the
    bearing [rad] of fine's column 0; picture: a small view where the flow is the whole image's.
    """

    fine: Float32Array
    coarse: Float32Array
    first_bearing: float
    picture: GreyView | None = None

    def rolled(self, turn: float) -> RingPair:
        """Return all of it rolled by an angle [rad]."""
        fine, coarse = (np.roll(r, round(turn * r.shape[1] / TAU), axis=1) for r in (self.fine, self.coarse))
        return RingPair(fine, coarse, self.first_bearing, self.picture.rolled(turn) if self.picture else None)


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
    to the convergence point (H26), "joined" counts the matches of both (6.3); start: stationary points of the ring's
    flow (1D) or of the whole image's (2D); band [rad]: Sakoe-Chiba's, how far a column may move. inhibition (H28;
    5.1.3.8): "mean" averages a home column's partners, "none" counts every pair, "target" keeps a home column's most
    alike partner, "reverse" a current one's, "both" either. swing [rad]: tries the current view in `rotations` turns
    within so much either way and keeps the match of least cost (5.1.3.4). unmoved: leaves out what moved by itself.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    wings: Wings = "unifying"
    spec: RingSpec = RING
    flow: FlowSpec = FLOW
    flow_columns: int = 180
    band: float = math.radians(50.0)
    inhibition: Inhibition = "mean"
    swing: float = 0.0
    rotations: int = 3
    start: Start = "ring"
    unmoved: bool = False

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        if self.unmoved:
            return Origin("own", "6.3, 6.4.2: background only")
        if self.wings == "joined":
            return Origin("own", "6.3: wing and unifying as one")
        if self.swing:
            return Origin("H28", "5.1.3.4, fig. 5.41")
        if self.inhibition != "mean":
            return Origin("H28", "5.1.3.8, fig. 5.40")
        row, source = ("H27", "5.16") if self.wings == "unifying" else ("H26", "5.15")
        return Origin(f"{row}, H25", f"{source}, 5.1.3.4") if self.start == "image" else Origin(row, source)

    def describe(self, panorama: Panorama) -> RingPair:
        """Return the rings the matching runs on."""
        spec = self.spec
        coarse = RingSpec(self.flow_columns, spec.bands, spec.top, spec.bottom, spec.blur, spec.colour)
        fine = ring(panorama, spec)
        first_bearing = 0.5 * (TAU / fine.shape[1] - TAU / panorama.rig.width)
        picture = grey_view(panorama, *VIEW) if self.start == "image" else None
        return RingPair(fine, ring(panorama, coarse), first_bearing, picture)

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
        return min((self._turned(current, goal, turn) for turn in self.turns()), key=lambda match: match.cost)

    def turns(self) -> list[float]:
        """Return the extra rotations [rad] that are tried, the smallest first, which wins a tie."""
        if self.swing <= 0.0:
            return [0.0]
        turns = np.linspace(-self.swing, self.swing, self.rotations).tolist()
        return sorted(turns, key=lambda turn: (round(abs(turn), 9), turn))

    def _turned(self, current: RingPair, goal: RingPair, turn: float) -> Match:
        """Match with the current view rolled by `turn` [rad], and turn the bearing back."""
        found = self._match(current.rolled(turn) if turn else current, goal)
        home = HomeVector(wrap(found.home.bearing - turn), None, found.home.confidence)
        return Match(home, found.cost)

    def _match(self, current: RingPair, goal: RingPair) -> Match:
        start = round(self.diffusion(current, goal) * goal.fine.shape[1] / TAU)
        there, here, cost = self._matched(current.fine, goal.fine, start)
        first = start * TAU / goal.fine.shape[1] + goal.first_bearing
        _, _, mirrored = self._matched(current.fine, np.ascontiguousarray(goal.fine[:, ::-1]), start)
        relative = cost / mirrored if mirrored > 1e-9 else 1.0
        there, here = there + first, here + first
        if self.unmoved:
            kept = still(there, here, matched_home(there, here, relative).bearing)
            there, here = there[kept], here[kept]
        return Match(matched_home(there, here, relative), relative)

    def diffusion(self, current: RingPair, goal: RingPair) -> float:
        """Return the bearing [rad] of the diffusion point, where the movement goal -> current led."""
        small, there = current.picture, goal.picture
        if small is not None and there is not None and small.tells and there.tells:
            return fitted_image_flow(small, there)[0].direction
        return fitted_flow(current.coarse, goal.coarse, self.flow).direction

    def _matched(self, current: Float32Array, goal: Float32Array, start: int) -> tuple[FloatArray, FloatArray, float]:
        """Return matched goal and current bearings from column `start` on, (M,) [rad] each, and the mean cost."""
        columns = goal.shape[1]
        here, there = np.roll(current, -start, axis=1), np.roll(goal, -start, axis=1)
        pieces: list[tuple[FloatArray, float]] = []
        if self.wings != "wing":
            pieces.append(self._paired(there, here, 0, columns))
        if self.wings != "unifying":
            half = columns // 2
            pieces += [self._paired(there, here, 0, half), self._paired(there, here, half, columns)]
        joined = np.concatenate([pairs for pairs, _ in pieces], axis=1) * (TAU / columns)
        return joined[0], joined[1], sum(cost for _, cost in pieces) / len(pieces)

    def _paired(self, there: Float32Array, here: Float32Array, first: int, end: int) -> tuple[FloatArray, float]:
        """Warp columns first .. end - 1; return the pairs (2, M) [columns] and the mean cost."""
        band = min(max(round(self.band * there.shape[1] / TAU), 1), end - first - 1)
        home, current = (np.ascontiguousarray(r[:, first:end]) for r in (there, here))
        if self.inhibition == "mean":
            shift, cost = dtw_path(home, current, band)
            own = np.arange(len(shift), dtype=np.float64)
            return np.stack([own, own + shift]) + first, cost
        goal, matched, unlike, cost = dtw_pairs(home, current, band)
        kept = inhibited(goal, matched, unlike, self.inhibition)
        return np.stack([goal[kept], matched[kept]]).astype(np.float64) + first, cost


def matched_home(there: FloatArray, here: FloatArray, cost: float) -> HomeVector:
    """Return the home vector (5.15, 5.16) of matched goal and current bearings (M,) [rad]; cost: as in `Match`."""
    x = float(np.sum(np.cos(here) - np.cos(there))) / len(there)
    y = float(np.sum(np.sin(here) - np.sin(there))) / len(there)
    sure = min(max(1.0 - cost, 0.0), 1.0) if math.hypot(x, y) > 1e-6 else 0.0
    return HomeVector(math.atan2(y, x), None, sure)
