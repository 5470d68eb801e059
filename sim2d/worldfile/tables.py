"""The tables of a world file, field by field."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from sim2d.furniture import KINDS
from sim2d.render.decals import DECALS
from sim2d.render.paint import PAINTERS
from sim2d.shapes import Colour, Decal, Ground, Look

Unit = Annotated[float, Field(ge=0, le=1)]
Metres = Annotated[float, Field(ge=-1e5, le=1e5)]
Positive = Annotated[float, Field(gt=0, le=1e5)]
Seed = Annotated[int, Field(ge=0)]
XY = tuple[Metres, Metres]
RGB = tuple[Unit, Unit, Unit]


def known(value: str, what: str, names: Collection[str]) -> str:
    """Return a name that is among those known. Raises ValueError."""
    if value not in names:
        raise ValueError(f"unknown {what}; there are {', '.join(sorted(names))}")
    return value


class Table(BaseModel):
    """A read-only table that refuses unknown keys, NaN and infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class DecalTable(Table):
    """A flat thing on a wall: see `sim2d.shapes.Decal`."""

    kind: str = Field(description="painter of `sim2d.render.decals`")
    start: float = Field(ge=0, description="from the wall's first point [m]")
    length: Positive
    base: float = Field(0.0, ge=0, description="lower edge above the floor [m]")
    top: Positive
    colour: RGB = (0.5, 0.5, 0.5)
    seed: Seed = 0

    @field_validator("kind")
    @classmethod
    def _known(cls, value: str) -> str:
        return known(value, "decal", DECALS)

    @model_validator(mode="after")
    def _upright(self) -> DecalTable:
        if self.base >= self.top:
            raise ValueError("its base must lie below its top")
        return self

    def decal(self) -> Decal:
        """Return the record."""
        return Decal(self.kind, self.start, self.length, self.base, self.top, self.colour, self.seed)


class ThingTable(Table):
    """What every thing has: a name, and a height up to the ceiling where none is given [m]."""

    name: str = ""
    height: Positive | None = None


class LookTable(Table):
    """What every surface has."""

    colour: RGB = (0.7, 0.68, 0.64)
    texture: str = Field("plaster", description="painter of `sim2d.render.paint`")
    seed: Seed = 0
    repeat: float = Field(0.0, ge=0, le=1e4, description="the picture repeats after so many metres, 0: never")

    glass: bool = Field(False, description="seen by the camera, but not by a range scanner")

    @field_validator("texture")
    @classmethod
    def _known(cls, value: str) -> str:
        return known(value, "texture", PAINTERS)

    def look(self, seed: int, decals: tuple[Decal, ...] = (), colour: Colour | None = None) -> Look:
        """Return the record; where the file gives no seed, `seed` counts."""
        own = self.seed if "seed" in self.model_fields_set else seed
        return Look(colour or self.colour, self.texture, own, decals, self.repeat, self.glass)


class GroundTable(LookTable):
    """Floor or ceiling."""

    colour: RGB = (0.5, 0.45, 0.4)
    texture: str = "speckle"
    tile: float = Field(6.4, gt=0, le=50, description="side of the square that repeats [m]")
    gloss: Unit = 0.0
    lamps: float = Field(0.0, ge=0, le=50, description="lamp spacing [m], 0: none")
    first_lamp: float = Field(1.6, ge=0, le=50, description="where the first lamp hangs [m]")

    def ground(self, seed: int) -> Ground:
        """Return the record."""
        return Ground(self.look(seed), self.tile, self.gloss, self.lamps, self.first_lamp)


class WallTable(LookTable, ThingTable):
    """A thin wall along points; `closed` leads it back to the first one."""

    points: tuple[XY, ...] = Field(min_length=2)
    closed: bool = False
    decals: tuple[DecalTable, ...] = ()


class PolygonTable(LookTable, ThingTable):
    """A solid with a simple outline, either way round."""

    points: tuple[XY, ...] = Field(min_length=3)
    decals: tuple[DecalTable, ...] = ()


class FurnitureTable(ThingTable):
    """A piece of furniture: kind, middle, size (w, d), turn; height and looks follow from its kind."""

    kind: str
    at: XY
    size: tuple[Positive, Positive]
    turn_deg: float = Field(0.0, ge=-360, le=360)
    colour: RGB | None = None
    seed: Seed | None = None

    @field_validator("kind")
    @classmethod
    def _known(cls, value: str) -> str:
        return known(value, "kind of furniture", KINDS)


class CylinderTable(LookTable, ThingTable):
    """An upright cylinder: bin, vase, plant, pillar."""

    at: XY
    radius: float = Field(gt=0, le=100)


class DoorTable(LookTable, ThingTable):
    """A door that closes a gap in a wall; opens and closes at laps, seconds or metres."""

    a: XY
    b: XY
    colour: RGB = (0.55, 0.36, 0.2)
    texture: str = "wood"
    opens_at: float | None = Field(None, ge=0, description="laps driven")
    closes_at: float | None = Field(None, ge=0, description="laps driven")
    opens_s: float | None = Field(None, ge=0, description="run time [s]")
    closes_s: float | None = Field(None, ge=0, description="run time [s]")
    opens_m: float | None = Field(None, ge=0, description="way driven [m]")
    closes_m: float | None = Field(None, ge=0, description="way driven [m]")
