"""What a homing method needs of its input, and the check before it is used."""

from __future__ import annotations

from dataclasses import dataclass

from topomap.core.errors import DataError
from topomap.core.panorama import Panorama
from topomap.vision.contracts import Needs as NeedsContract


@dataclass(frozen=True, slots=True)
class Needs:
    """compass: aligned panoramas; ranges, colour, camera_height: what the robot must provide."""

    compass: bool = False
    ranges: bool = False
    colour: bool = False
    camera_height: bool = False


def check(needs: NeedsContract, panorama: Panorama) -> None:
    """Raise DataError when the panorama lacks what the method needs."""
    if needs.ranges and panorama.ranges is None:
        raise DataError("this homing method needs measured ranges, and the panorama has none")
    if needs.camera_height and panorama.rig.camera_height <= 0.0:
        raise DataError("this homing method needs the camera's height, and the rig doesn't tell it")
