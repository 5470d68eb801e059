"""The rig file of a mirror camera: where its ring lies in a raw picture, and how large the panorama shall be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, Field, ValidationError

from topomap.core.arrays import Image
from topomap.core.errors import DataError
from topomap.core.files import read_toml
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.unwrap import MirrorRig, unwrap


class MirrorFile(BaseModel, frozen=True, extra="forbid"):
    """What a mirror's rig file says; lengths in pixels of the raw picture."""

    x: float = Field(description="column of the ring's centre")
    y: float = Field(description="row of the ring's centre")
    inner: float = Field(ge=0, description="inner radius")
    outer: float = Field(gt=0, description="outer radius")
    forward_deg: float = Field(0.0, description="direction of the nose in the picture, from +x towards +y (down)")
    turn: Literal["clockwise", "counter-clockwise"] = Field("counter-clockwise", description="how bearings run there")
    inner_is_floor: bool = Field(True, description="whether the inner rim shows the floor")
    width: int = Field(720, ge=8, le=7200, description="columns of the panorama")
    height: int = Field(100, ge=4, le=2000, description="rows of the panorama")


@dataclass(frozen=True, slots=True)
class Unwrapper:
    """Turns raw pictures of one mirror into panoramas; horizon_row None: the middle; camera_height 0: unknown [m]."""

    file: MirrorFile
    horizon_row: float | None = None
    camera_height: float = 0.0

    def panorama(self, raw: Image) -> Panorama:
        """Return the panorama of a raw picture (R, C, 3). Raises DataError, ShapeError."""
        said = self.file
        mirror = MirrorRig(
            said.x, said.y, said.inner, said.outer, math.radians(said.forward_deg), said.turn, said.inner_is_floor
        )
        horizon = (said.height - 1) / 2 if self.horizon_row is None else self.horizon_row
        return unwrap(raw, mirror, Rig(said.width, said.height, horizon, said.width / TAU, self.camera_height))


def read_mirror(path: Path) -> MirrorFile:
    """Read a mirror's rig file. Raises DataError that names file and key."""
    try:
        return MirrorFile.model_validate(read_toml(path))
    except ValidationError as error:
        first = error.errors()[0]
        raise DataError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    except (OSError, ValueError, RecursionError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error


def mirror_text(mirror: MirrorRig) -> str:
    """Return the rig file of a mirror that was found in a picture."""
    return (
        f"x = {mirror.x:.2f}\ny = {mirror.y:.2f}\ninner = {mirror.inner:.2f}\nouter = {mirror.outer:.2f}\n"
        f'forward_deg = {math.degrees(mirror.forward):.3f}\nturn = "{mirror.turn}"\n'
        f"inner_is_floor = {str(mirror.inner_is_floor).lower()}\n"
    )
