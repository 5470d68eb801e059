"""The small Protocols of vision: where views come from, and what aligners and homing methods do with them."""

from __future__ import annotations

from typing import Protocol, TypeVar

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector

D = TypeVar("D")


class ViewSource(Protocol):
    """The view at a pose [m, rad], from a world or an image grid; for benches."""

    def view(self, x: float, y: float, heading: float) -> Panorama: ...


class Aligner(Protocol):
    """Finds how the current view is turned against the goal view; pure."""

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the alignment; `prior` is a rotation [rad] from odometry near which to search, where there is one."""


class Needs(Protocol):
    """What a homing method needs of its input, checked before use."""

    @property
    def compass(self) -> bool: ...
    @property
    def ranges(self) -> bool: ...
    @property
    def colour(self) -> bool: ...
    @property
    def camera_height(self) -> bool: ...


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
