"""The rig of a drive's panoramas: what `rig.json` says, and what is taken where it says nothing."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import BaseModel, Field, ValidationError

from topomap.core.errors import DataError
from topomap.core.files import TEXT, regular
from topomap.core.geometry import TAU
from topomap.core.recorded import RecordedRig

NAME = "rig.json"


class RigFile(BaseModel, frozen=True, extra="ignore"):
    """How the panoramas were taken; keys that say other things are left alone."""

    width: int | None = Field(None, ge=8, le=7200, description="columns; none: those of the first image")
    height: int | None = Field(None, ge=4, le=2000, description="rows; none: those of the first image")
    horizon_row: float | None = Field(None, description="row of eye level, may lie outside; none: found in the images")
    focal: float | None = Field(None, gt=0, description="of the cylinder [pixels]; none: width / (2 pi)")
    camera_height: float = Field(0.0, ge=0, description="eye level above the floor [m]; 0: unknown")
    forward_column: int | None = Field(None, ge=0, description="column along the nose; none: the middle one")
    clockwise: bool = Field(True, description="columns run clockwise, as people read a panorama")

    def rig(self, horizon_row: float) -> RecordedRig:
        """Return the rig of panoramas whose size is known by now; horizon_row: where the file doesn't tell it."""
        assert self.width is not None
        assert self.height is not None
        nose = self.width // 2 if self.forward_column is None else self.forward_column
        row = horizon_row if self.horizon_row is None else self.horizon_row
        focal = self.width / TAU if self.focal is None else self.focal
        return RecordedRig(self.width, self.height, row, focal, self.camera_height, nose, self.clockwise)


def read_rig(path: Path, width: int, height: int) -> RigFile:
    """Read a rig file for panoramas (height, width). Raises DataError that names file, key, value and what is right."""
    said = _read(path)
    for name, told, seen in (("width", said.width, width), ("height", said.height, height)):
        if told is not None and told != seen:
            raise DataError(f"{path}: {name}: {told}, but the first image has {seen}")
    if said.forward_column is not None and said.forward_column >= width:
        raise DataError(f"{path}: forward_column: {said.forward_column}, but the images have {width} columns")
    return said.model_copy(update={"width": width, "height": height})


def _read(path: Path) -> RigFile:
    try:
        return RigFile.model_validate(json.loads(regular(path, TEXT).read_text(encoding="utf8")))
    except FileNotFoundError:
        return RigFile()
    except (OSError, json.JSONDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise DataError(f"{path}: {where}: {first['input']!r}: {first['msg'][0].lower()}{first['msg'][1:]}") from error
