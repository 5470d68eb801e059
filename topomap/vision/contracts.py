"""The small Protocols of vision: where views come from, and what aligners and homing methods do with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar, runtime_checkable

from topomap.core.errors import DataError, ShapeError
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector

D = TypeVar("D")
S = TypeVar("S")


class ViewSource(Protocol):
    """The view at a pose [m, rad], from a world or an image grid; for benches."""

    def view(self, x: float, y: float, heading: float) -> Panorama: ...


@dataclass(frozen=True, slots=True)
class Needs:
    """What a method needs. compass: aligned panoramas; ranges, colour, camera_height: what the robot must provide;
    heading: a rotation from odometry.
    """

    compass: bool = False
    ranges: bool = False
    colour: bool = False
    camera_height: bool = False
    heading: bool = False

    def check(self, panorama: Panorama) -> None:
        """Raise DataError when the panorama lacks what is needed."""
        if self.ranges and panorama.ranges is None:
            raise DataError("this homing method needs measured ranges, and the panorama has none")
        if self.camera_height and panorama.rig.camera_height <= 0.0:
            raise DataError("this homing method needs the camera's height, and the rig doesn't tell it")


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a method of the registry comes from: its row of the survey (A1-A8, H1-H28, own) and its source."""

    row: str
    source: str


@runtime_checkable
class Listed(Protocol):
    """What a method of the registry says of itself."""

    @property
    def origin(self) -> Origin: ...
    @property
    def needs(self) -> Needs: ...
    @property
    def claims_homing(self) -> bool: ...


@dataclass(frozen=True, slots=True, eq=False)
class GoalView:
    """Three views of a goal: home there, x and y at `step` [m] ahead and to the left of it, all looking the goal's way.

    Raises ShapeError when the three differ in size.
    """

    home: Panorama
    x: Panorama
    y: Panorama
    step: float = 0.1

    def __post_init__(self) -> None:
        """Refuse views of different cameras."""
        if not self.home.image.shape == self.x.image.shape == self.y.image.shape or self.step <= 0.0:
            raise ShapeError("a goal view is three panoramas of one camera, a positive step apart")


@runtime_checkable
class Aligner(Protocol):
    """Finds how the current view is turned against the goal view; pure."""

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the alignment; `prior` is a rotation [rad] from odometry near which to search, where there is one."""


@runtime_checkable
class Preparing(Protocol):
    """An aligner that can do beforehand, and once, what it asks of a single view."""

    def prepare(self, panorama: Panorama) -> None:
        """Derive it; the view keeps it."""


@runtime_checkable
class HomingMethod(Protocol[D]):
    """A pure function of two described panoramas; D is what it keeps of a snapshot.

    A method with `needs.compass` is given aligned panoramas; `claims_homing` is False for fields that can't home
    alone, which are tested against their analytic field instead.
    """

    @property
    def needs(self) -> Needs: ...
    @property
    def claims_homing(self) -> bool: ...

    def describe(self, panorama: Panorama) -> D: ...

    def home(self, current: D, goal: D) -> HomeVector: ...


@runtime_checkable
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


@runtime_checkable
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
