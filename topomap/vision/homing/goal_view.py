"""The two other contracts of homing: with reference views around the goal, and by acting and looking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from topomap.core.errors import ShapeError
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs

S = TypeVar("S")


@dataclass(frozen=True, slots=True, eq=False)
class GoalView:
    """What was taken at the goal: home there, x and y at `step` [m] ahead and to the left of it, all looking
    the goal's way. Raises ShapeError when the three differ in size.
    """

    home: Panorama
    x: Panorama
    y: Panorama
    step: float = 0.1

    def __post_init__(self) -> None:
        """Refuse views of different cameras."""
        if not self.home.image.shape == self.x.image.shape == self.y.image.shape or self.step <= 0.0:
            raise ShapeError("a goal view is three panoramas of one camera, a positive step apart")


class ReferenceHoming(Protocol):
    """A pure function of an aligned current view and the goal's three views.

    step [m]: how far from the goal the references should be taken.
    """

    @property
    def needs(self) -> Needs: ...
    @property
    def claims_homing(self) -> bool: ...
    @property
    def step(self) -> float: ...

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        """Return the bearing of the goal in the aligned frame. Raises ShapeError."""


class HomingPolicy(Protocol[S]):
    """Acts and looks: its state is explicit, its answer is the next move.

    Every move is (bearing, distance) in the aligned frame; the next `step` is given the view after it.
    """

    @property
    def needs(self) -> Needs: ...
    @property
    def claims_homing(self) -> bool: ...

    def start(self, goal: Panorama) -> S:
        """Return the state before the first look."""

    def step(self, state: S, current: Panorama) -> tuple[S, HomeVector]:
        """Return the next state and the next move; its distance [m] is always given. Raises ShapeError."""
