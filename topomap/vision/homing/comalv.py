"""H4, H5: the centre-of-mass landmark vector (Hafner 2001; 2.5.1.1, 2.7), alone and with three references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import GoalView, Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference, same_views, vector_home
from topomap.vision.image.compare import normalised, shrunk


@dataclass(frozen=True, slots=True)
class CentreOfMass:
    """Sum over ommatidia of intensity * u, at the current place minus at the goal (COMALV); claims no homing.

    The field has a saddle at the goal: its bearing is off by 85-93 deg with either sign. ommatidia: columns of
    the low-passed view; rows: share of the height about the horizon (+-40 of 100); edges: weigh with the
    horizontal gradient's size instead of the intensity.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = False
    ommatidia: int = 90
    rows: float = 0.8
    edges: bool = False

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        return Origin("H4", "2.5.1.1, edge-weighted" if self.edges else "2.5.1.1; Hafner 2001")

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the centre-of-mass vector O."""
        small = normalised(shrunk(panorama, self.ommatidia, 50, 1.0))
        cut = round(len(small) * (1.0 - self.rows) / 2.0)
        rings = small[cut : max(len(small) - cut, cut + 1)]
        if self.edges:
            rings = np.abs(np.roll(rings, -1, axis=1) - np.roll(rings, 1, axis=1))
        outputs = rings.mean(axis=0, dtype=np.float64)
        columns = len(outputs)
        angles = np.arange(columns) * (TAU / columns) + 0.5 * (TAU / columns - TAU / panorama.rig.width)
        x, y = float(np.sum(outputs * np.cos(angles))), float(np.sum(outputs * np.sin(angles)))
        return ViewVector(x / columns, y / columns, 1.0 if small.any() else 0.0, panorama.rig)

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of O_C - O_H in the aligned frame. Raises ShapeError."""
        return difference(current, goal)


class Field(Protocol):
    """Anything that makes a view one vector."""

    @property
    def origin(self) -> Origin: ...

    def describe(self, panorama: Panorama) -> ViewVector: ...


@dataclass(frozen=True, slots=True)
class ReferenceJacobian:
    """-J^-1 (O_C - O_H), with the field's Jacobian J from the goal's references: saddles home as well (H4, H19)."""

    needs: ClassVar[Needs] = Needs(compass=True)
    field: Field
    step: float = 0.1

    @property
    def origin(self) -> Origin:
        """The field's, with references."""
        return Origin(self.field.origin.row, f"{self.field.origin.source}, Jacobian of three references")

    @property
    def claims_homing(self) -> bool:
        """Whether the field is smooth enough for a Jacobian: random masks' absolute scores are not."""
        return isinstance(self.field, CentreOfMass)

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal.home)
        o_c, o_h, o_x, o_y = (_array(self.field.describe(p)) for p in (current, goal.home, goal.x, goal.y))
        jacobian = np.column_stack([o_x - o_h, o_y - o_h]) / goal.step
        size = float(np.abs(jacobian).max())
        if size < 1e-9 or abs(np.linalg.det(jacobian)) < 1e-4 * size**2:
            return HomeVector(0.0, None, 0.0)
        x, y = -np.linalg.solve(jacobian, o_c - o_h)
        return vector_home(float(x), float(y), float(np.hypot(x, y)) + 0.1, 0.5)


@dataclass(frozen=True, slots=True)
class ModifiedCentreOfMass:
    """Distances of the current O to those of three references, differences as in DID (MCOMALV; 2.7)."""

    origin: ClassVar[Origin] = Origin("H5", "2.7")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    field: CentreOfMass = CentreOfMass()
    step: float = 0.1

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal.home)
        here = _array(self.field.describe(current))
        apart = [np.hypot(*(_array(self.field.describe(p)) - here)) for p in (goal.home, goal.x, goal.y)]
        x, y = float(apart[1] - apart[0]), float(apart[2] - apart[0])
        return vector_home(x, y, float(sum(apart)) + 1e-9, 0.5 if apart[0] > 1e-9 else 0.0)


def _array(vector: ViewVector) -> FloatArray:
    return np.array([vector.x, vector.y])
