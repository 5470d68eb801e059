"""The small Protocols through which the stack meets robots and worlds.

Everything a robot hands over is a read-only property over primitives, so that a simulator, a log or a driver for
real hardware can own its own classes and fit structurally, without importing topomap.
"""

from __future__ import annotations

from typing import Protocol

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.records import Command


class MotionReading(Protocol):
    """An odometry increment: forward [m], left [m], turn [rad], covariance (3, 3) of these, dt [s]."""

    @property
    def forward(self) -> float: ...
    @property
    def left(self) -> float: ...
    @property
    def turn(self) -> float: ...
    @property
    def covariance(self) -> FloatArray: ...
    @property
    def dt(self) -> float: ...


class RigReading(Protocol):
    """How the recorded panorama was taken.

    width W, height H [pixels]; horizon_row: the (fractional) row of eye level, 49.5 of 100; focal [pixels] of the
    cylinder, W/(2 pi); camera_height [m]; forward_column: the recorded column that looks along the nose; clockwise:
    whether recorded columns run clockwise (as people read a panorama) or counter-clockwise.
    """

    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def horizon_row(self) -> float: ...
    @property
    def focal(self) -> float: ...
    @property
    def camera_height(self) -> float: ...
    @property
    def forward_column(self) -> int: ...
    @property
    def clockwise(self) -> bool: ...


class Reading(Protocol):
    """What a robot senses in one step.

    stamp_ns; image (H, W, 3) uint8 RGB as recorded (see rig), decoded from `encoded`, the very bytes that are logged;
    ranges (W,) float32 [m] or None, entry j along bearing 2 pi j/W from the nose, counter-clockwise, NaN where
    nothing was measured; motion: the increment since the previous reading; contact: the bumper is pressed; driven:
    somebody else (a person, a script) has the wheels and commands are ignored. A stamp that isn't later than the one
    before and an increment that isn't numbers, or beyond 1e7 m or rad, end the run with a DataError.
    """

    @property
    def stamp_ns(self) -> int: ...
    @property
    def image(self) -> Image: ...
    @property
    def encoded(self) -> bytes: ...
    @property
    def ranges(self) -> Float32Array | None: ...
    @property
    def motion(self) -> MotionReading: ...
    @property
    def rig(self) -> RigReading: ...
    @property
    def contact(self) -> bool: ...
    @property
    def driven(self) -> bool: ...


class Robot(Protocol):
    """A simulator, a replay, a data set or a driver for real hardware."""

    def sense(self) -> Reading | None:
        """Return the next reading, or None when the run is over."""

    def act(self, command: Command) -> None:
        """Set the wheels; they keep the command until the next one."""

    def stop(self) -> None:
        """Stop the wheels: always called, at the end, on Ctrl-C, after a crash or a lost sensor."""


class Truth(Protocol):
    """The true pose at a stamp, in the world's frame [m, rad], and whether the body touches something."""

    @property
    def stamp_ns(self) -> int: ...
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def heading(self) -> float: ...
    @property
    def contact(self) -> bool: ...


class TruthSource(Protocol):
    """Wired to the recorder and the metrics only; the stack never sees it."""

    def truth(self) -> Truth | None: ...


class PlanReading(Protocol):
    """A world's plan, in the truth's frame [m]: polylines (N, 2), circles (x, y, r), labels (x, y, text)."""

    @property
    def polylines(self) -> tuple[FloatArray, ...]: ...
    @property
    def circles(self) -> tuple[tuple[float, float, float], ...]: ...
    @property
    def labels(self) -> tuple[tuple[float, float, str], ...]: ...
