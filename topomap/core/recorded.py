"""Ready-made records for a robot's driver: its camera rig and what it senses in one step."""

from __future__ import annotations

from dataclasses import InitVar, dataclass, field

import numpy as np

from topomap.core.arrays import Float32Array, Image
from topomap.core.encoded import decode, encode
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU
from topomap.core.robot import MotionReading, RigReading

Spans = tuple[tuple[float, float], ...]
"""Parts of a view: the bearing of each one's right edge, and how far it reaches to the left [rad]."""


@dataclass(frozen=True, slots=True)
class RecordedRig:
    """How recorded panoramas were taken; fits `topomap.core.robot.RigReading`, which says what the fields mean.

    roll: to the right, pitch: forward [rad]: how the camera leant, as was found in its views; hidden: what the robot
    itself hid of them.
    """

    width: int
    height: int
    horizon_row: float
    focal: float
    camera_height: float
    forward_column: int
    clockwise: bool
    roll: float = 0.0
    pitch: float = 0.0
    hidden: Spans = ()

    @staticmethod
    def of(rig: RigReading) -> RecordedRig:
        """Return an own copy of a reading's rig, in plain Python numbers."""
        return RecordedRig(
            int(rig.width),
            int(rig.height),
            float(rig.horizon_row),
            float(rig.focal),
            float(rig.camera_height),
            int(rig.forward_column),
            bool(rig.clockwise),
        )

    @staticmethod
    def cylinder(
        width: int,
        height: int,
        camera_height: float,
        horizon_row: float | None = None,
        forward_column: int | None = None,
        clockwise: bool = True,
    ) -> RecordedRig:
        """Return the rig of square pixels on a cylinder; where nothing else is said eye level and nose are mid-image.

        width, height [pixels]; camera_height above the floor [m]; clockwise: as people read a panorama.
        """
        row = (height - 1) / 2 if horizon_row is None else horizon_row
        nose = width // 2 if forward_column is None else forward_column
        return RecordedRig(width, height, row, width / TAU, camera_height, nose, clockwise)


def _nothing() -> Image:
    return np.zeros((0, 0, 3), np.uint8)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RecordedReading:
    """One step's senses; fits `topomap.core.robot.Reading`, which says what the fields mean.

    Give `image` (H, W, 3) uint8 RGB, encoded as PNG or, where `quality` (1..100) is given, as JPEG; or give `encoded`,
    the camera's own PNG or JPEG bytes. The image is always what the bytes decode to: the stack sees what is logged.
    ranges (W,) [m] become float32. Raises ShapeError for arrays that aren't what the rig says, DataError for bytes
    that aren't an image.
    """

    stamp_ns: int
    motion: MotionReading
    rig: RigReading
    image: Image = field(default_factory=_nothing)
    encoded: bytes = b""
    ranges: Float32Array | None = None
    contact: bool = False
    driven: bool = False
    quality: InitVar[int | None] = None

    def __post_init__(self, quality: int | None) -> None:
        given = not self.encoded
        if given:
            object.__setattr__(self, "encoded", encode(self.image, quality))
        if not given or quality is not None:
            object.__setattr__(self, "image", decode(self.encoded))
        if self.image.shape != (self.rig.height, self.rig.width, 3):
            raise ShapeError(f"image is {self.image.shape}, the rig says ({self.rig.height}, {self.rig.width}, 3)")
        if self.ranges is not None:
            object.__setattr__(self, "ranges", np.asarray(self.ranges, np.float32))
            if self.ranges.shape != (self.rig.width,):
                raise ShapeError(f"ranges are {self.ranges.shape}, the rig says ({self.rig.width},)")
