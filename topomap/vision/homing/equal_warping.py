"""H9, H10: 1D and 2D warping under equal distances (Franz et al. 1998; Möller et al. 2010; 2.5.2.1, 2.5.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.ring import RingSpec, ring
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, WarpingView, warping_view
from topomap.vision.matching.equal_distance_search import Steps, equal_search, found, tables
from topomap.vision.matching.warping import least_home, rotations
from topomap.vision.matching.warping_kernels import scale_planes

STEPS = Steps()
RING_144 = RingSpec(columns=144, bands=3, blur=2.0)


@dataclass(frozen=True, slots=True, eq=False)
class RingView:
    """The horizon ring at each phase (1, P, F, n), and the bearing [rad] of column 0."""

    columns: Float32Array
    first_bearing: float


@dataclass(frozen=True, slots=True)
class RingWarping:
    """Direction, rotation and relative step that warp the goal's ring best into the current one (1D warping).

    ring: bands, blurred; phases: fractions of a column a landmark may move by; steps: relative steps tried;
    window [rad]: how far the views may be turned against each other. Bearing only; own compass.
    """

    origin: ClassVar[Origin] = Origin("H9", "2.5.2.1; Franz et al. 1998")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    spec: RingSpec = RING_144
    phases: int = 2
    steps: Steps = STEPS
    window: float = math.pi

    def describe(self, panorama: Panorama) -> RingView:
        """Return the ring, split into phases."""
        bands = ring(panorama, self.spec)
        phases = self.phases if bands.shape[1] >= 2 * self.phases else 1
        n = bands.shape[1] // phases
        split = bands[:, : n * phases].reshape(len(bands), n, phases).transpose(2, 0, 1)[np.newaxis]
        return RingView(np.ascontiguousarray(split), 0.5 * (TAU / (n * phases) - TAU / panorama.rig.width))

    def home(self, current: RingView, goal: RingView) -> HomeVector:
        """Return the bearing [rad] of the goal in the current robot's frame. Raises ShapeError."""
        if current.columns.shape != goal.columns.shape:
            raise ShapeError(f"rings differ in shape: {current.columns.shape} and {goal.columns.shape}")
        _, phases, _, n = goal.columns.shape
        nothing = np.zeros((1, phases, n), np.float32)
        planes = scale_planes(goal.columns, current.columns, nothing, nothing, float(goal.columns.shape[2]))
        first, width = rotations(0.0, self.window, n)
        cost = equal_search(planes, *tables(n, phases, 0, 2.0, self.steps), first, width)
        seen = bool(goal.columns.any() and current.columns.any())
        return least_home(found(cost, first, goal.first_bearing, seen))


@dataclass(frozen=True, slots=True)
class EqualWarping:
    """1D warping with the columns' vertical scaling, on the scale-plane stack (2D warping); own compass.

    Free (dp) warping is named only in the thesis. Fields as in `RingWarping`.
    """

    origin: ClassVar[Origin] = Origin("H10", "2.5.2.2; Möller et al. 2010")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    spec: WarpingSpec = WARPING
    steps: Steps = STEPS
    window: float = math.pi

    def describe(self, panorama: Panorama) -> WarpingView:
        """Return the view's magnified edge columns."""
        return warping_view(panorama, self.spec)

    def home(self, current: WarpingView, goal: WarpingView) -> HomeVector:
        """Return the bearing [rad] of the goal in the current robot's frame. Raises ShapeError."""
        if current.edges.shape != goal.edges.shape:
            raise ShapeError(f"views differ in shape: {current.edges.shape} and {goal.edges.shape}")
        levels, phases, _, n = goal.edges.shape
        floor = self.spec.floor * float(goal.sums[0, 0].mean() + current.sums[0, 0].mean())
        planes = scale_planes(goal.edges, current.edges, goal.sums, current.sums, floor)
        first, width = rotations(0.0, self.window, n)
        cost = equal_search(planes, *tables(n, phases, levels - 1, self.spec.step, self.steps), first, width)
        seen = bool(goal.sums.any() and current.sums.any())
        return least_home(found(cost, first, goal.first_bearing, seen))
