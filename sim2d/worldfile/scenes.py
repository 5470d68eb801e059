"""The tables of a world file for what happens in it, and the whole file."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from sim2d.worldfile.tables import (
    RGB,
    XY,
    CylinderTable,
    DoorTable,
    FurnitureTable,
    GroundTable,
    Metres,
    PolygonTable,
    Positive,
    Seed,
    Table,
    WallTable,
)


class LightTable(Table):
    """A lamp at a place, or a window: a stretch of a wall, which is painted there as well."""

    kind: Literal["lamp", "window"] = "lamp"
    at: XY | None = Field(None, description="of a lamp [m]")
    z: Positive | None = Field(None, description="height of a lamp [m]; not given: just below the ceiling")
    strength: float = Field(1.0, ge=0, le=100)
    colour: RGB = (1.0, 1.0, 1.0)
    wall: str = Field("", description="name of a window's wall, of two points")
    start: float = Field(0.0, ge=0, description="of a window from the wall's first point [m]")
    length: Positive = 1.0
    sill: float = Field(0.9, ge=0, description="lower edge of a window [m]")
    top: Positive = 2.1
    frame: RGB = (0.9, 0.9, 0.9)
    seed: Seed = 0

    @model_validator(mode="after")
    def _whole(self) -> LightTable:
        if self.kind == "lamp" and self.at is None:
            raise ValueError("a lamp needs at = [x, y]")
        if self.kind == "window" and not self.wall:
            raise ValueError("a window needs the name of its wall")
        if self.kind == "window" and self.sill >= self.top:
            raise ValueError("a window's sill must lie below its top")
        return self


class PersonTable(Table):
    """Somebody who walks to and fro."""

    name: str = ""
    route: tuple[XY, ...] = Field(min_length=2)
    speed: float = Field(0.8, ge=0, le=3, description="[m/s]")
    radius: float = Field(0.25, gt=0, le=1, description="[m]")
    height: float = Field(1.75, gt=0, le=2.5, description="[m]")
    colour: RGB = (0.3, 0.35, 0.6)
    seed: Seed = 0
    start_s: float = Field(0.0, ge=0, description="[s]")


class ChangeTable(Table):
    """What happens once: to whom, when (seconds or laps), and what."""

    name: str
    at_s: float | None = Field(None, ge=0)
    at_lap: float | None = Field(None, ge=0)
    opens: bool | None = None
    moves_to: XY | None = None
    turn_deg: float = Field(0.0, ge=-360, le=360)

    @model_validator(mode="after")
    def _whole(self) -> ChangeTable:
        if (self.at_s is None) == (self.at_lap is None):
            raise ValueError("a change needs either at_s or at_lap")
        if (self.opens is None) == (self.moves_to is None):
            raise ValueError("a change needs either opens or moves_to")
        return self


class RouteTable(Table):
    """Where the driver goes: see `sim2d.shapes.Route`."""

    ring: tuple[XY, ...] = Field(min_length=2)
    laps: float = Field(1.0, gt=0, le=1000)
    tail: tuple[XY, ...] = ()
    radius: float = Field(0.7, ge=0.05, le=20)
    both_ways: bool = False

    @model_validator(mode="after")
    def _whole(self) -> RouteTable:
        if self.tail and self.laps != round(self.laps):
            raise ValueError("a route with a tail needs whole laps")
        return self


class PlaceTable(Table):
    """A named place."""

    x: Metres
    y: Metres
    heading_deg: float = Field(0.0, ge=-360, le=360)


class GridTable(Table):
    """Positions for homing benches."""

    origin: XY
    spacing: Positive
    columns: int = Field(ge=1, le=1000)
    rows: int = Field(ge=1, le=1000)


class LabelTable(Table):
    """A word on the plan."""

    x: Metres
    y: Metres
    text: str


class WorldTable(Table):
    """A world file."""

    extends: str = Field("", description="name or file of a world file that this one adds to")
    name: str = Field(min_length=1)
    purpose: str = ""
    ceiling_height: float = Field(2.6, gt=0, le=100)
    floor: GroundTable = GroundTable()
    ceiling: GroundTable = GroundTable(colour=(0.82, 0.82, 0.8), texture="plaster", lamps=3.2)
    route: RouteTable
    routes: dict[str, RouteTable] = Field(default_factory=dict)
    goal: XY | None = None
    wall: tuple[WallTable, ...] = Field(min_length=1)
    polygon: tuple[PolygonTable, ...] = ()
    furniture: tuple[FurnitureTable, ...] = ()
    cylinder: tuple[CylinderTable, ...] = ()
    pillar: tuple[CylinderTable, ...] = ()
    door: tuple[DoorTable, ...] = ()
    light: tuple[LightTable, ...] = ()
    person: tuple[PersonTable, ...] = ()
    change: tuple[ChangeTable, ...] = ()
    places: dict[str, PlaceTable] = Field(default_factory=dict)
    grid: GridTable | None = None
    label: tuple[LabelTable, ...] = ()
