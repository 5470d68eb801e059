"""The simulator's configuration; every default stands here and nowhere else."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Section(BaseModel):
    """A read-only section that refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class CameraConfig(Section):
    """The panoramic camera."""

    width: int = Field(720, ge=8, le=7200, description="columns of the panorama [pixels]")
    height: int = Field(100, ge=4, le=2000, description="rows of the panorama [pixels]")
    camera_height: float = Field(0.6, gt=0, le=3, description="eye level above the floor [m]")
    forward_column: int = Field(360, ge=0, description="recorded column that looks along the nose")
    clockwise: bool = Field(True, description="recorded columns run clockwise")
    codec: Literal["jpeg", "png"] = Field("jpeg", description="image codec of the camera")
    quality: int = Field(90, ge=1, le=100, description="JPEG quality")
    noise: float = Field(2.0, ge=0, le=64, description="sensor noise, standard deviation [grey levels]")
    gain: float = Field(1.0, gt=0, le=8, description="exposure gain")


class LaserConfig(Section):
    """The range scanner."""

    rays: int = Field(720, ge=1, le=7200, description="rays per turn")
    noise: float = Field(0.01, ge=0, description="range noise, standard deviation [m]")
    max_range: float = Field(10.0, gt=0, description="nothing is measured beyond [m]")
    dropout: float = Field(0.002, ge=0, le=1, description="share of rays that return nothing")


class OdometerConfig(Section):
    """Errors: forward_read = distance_scale * forward; turn_read = rotation_scale * turn + curvature * forward."""

    distance_scale: float = Field(0.95, gt=0, description="distance read per true metre")
    rotation_scale: float = Field(1.04, gt=0, description="turn read per true turn")
    curvature: float = Field(0.003, description="turn read per true metre, from unequal wheels [rad/m]")
    forward_noise: float = Field(0.02, ge=0, description="random distance error [m per sqrt m]")
    turn_noise_deg: float = Field(0.5, ge=0, description="random turn error [degree per sqrt m]")
    spread: float = Field(
        0.2, ge=0, lt=1, description="each systematic error is multiplied by uniform(1 - spread, 1 + spread)"
    )


class BodyConfig(Section):
    """The differential-drive body."""

    radius: float = Field(0.2, gt=0, le=2, description="robot radius [m]")
    max_speed: float = Field(0.4, gt=0, description="greatest forward speed [m/s]")
    max_turn: float = Field(0.8, gt=0, description="greatest turn rate [rad/s]")
    step: float = Field(0.25, gt=0, le=2, description="time from one reading to the next [s]")


class DriverConfig(Section):
    """The driver who teaches the route."""

    route: str = Field("", description="name of the world's route to drive instead of its default one")
    laps: float | None = Field(None, gt=0, description="laps to drive instead of the world's own number")
    lateral_offset: float = Field(0.0, description="offset to the left from lap two on [m]")
    lookahead: float = Field(0.4, gt=0, description="distance to the point that is steered at [m]")


class SimConfig(Section):
    """All of the simulator."""

    camera: CameraConfig = Field(default_factory=CameraConfig, description="panoramic camera")
    laser: LaserConfig = Field(default_factory=LaserConfig, description="range scanner")
    odometer: OdometerConfig = Field(default_factory=OdometerConfig, description="odometer and its errors")
    body: BodyConfig = Field(default_factory=BodyConfig, description="robot body")
    driver: DriverConfig = Field(default_factory=DriverConfig, description="driver of the taught route")
