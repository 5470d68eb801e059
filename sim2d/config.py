"""The simulator's configuration; every default stands here and nowhere else."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator


class Section(BaseModel):
    """A read-only section that refuses unknown keys.

    FLAWS: its fields that make a robot or its surroundings worse than they usually are.
    """

    FLAWS: ClassVar[tuple[str, ...]] = ()
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class LightChange(Section):
    """Another hour of the day from a time or a lap on."""

    hour: float = Field(ge=0, le=24, description="hour of the day")
    at_s: float | None = Field(None, ge=0, le=1e6, description="run time from which on it holds [s]")
    at_lap: float | None = Field(None, ge=0, le=1000, description="laps driven from which on it holds")

    @model_validator(mode="after")
    def _has_one_moment(self) -> Self:
        if (self.at_s is None) == (self.at_lap is None):
            raise ValueError("give at_s or at_lap, and not both")
        return self


class LensConfig(Section):
    """The optics: lenses side by side, or a mirror on supports."""

    lenses: int = Field(2, ge=1, le=12, description="lenses that share the turn, the first along the nose")
    vignetting: float = Field(0.0, ge=0, lt=1, description="share of light lost in the corners of each lens")
    seam: float = Field(0.0, ge=0, le=0.5, description="how the lenses differ in colour gain, standard deviation [ln]")
    supports: int = Field(0, ge=0, le=8, description="bars that hold a mirror, the first one behind")
    support_deg: float = Field(2.0, gt=0, le=30, description="width of such a bar [degree]")


class ShutterConfig(Section):
    """Motion in the picture: how long it is exposed, and how long its rows take one after the other."""

    exposure: float = Field(0.0, ge=0, le=1, description="exposure time [s]")
    readout: float = Field(0.0, ge=0, le=1, description="time from the first row's exposure to the last one's [s]")


class SwayConfig(Section):
    """Tilt that follows the motion and the floor."""

    per_acceleration_deg: float = Field(0.0, ge=0, le=45, description="lean by acceleration [degree per m/s2]")
    bumps_deg: float = Field(0.0, ge=0, le=20, description="lean by the floor's bumps, standard deviation [degree]")
    bump_length: float = Field(0.5, ge=0.05, le=100, description="extent of a bump [m]")


class CameraConfig(Section):
    """The panoramic camera."""

    FLAWS = (
        "gain", "exposure", "exposure_lag", "white_balance", "light_changes", "hour_rate", "blur", "roll_deg",
        "pitch_deg", "missing", "repeated", "lag", "quality", "max_bytes", "lens", "shutter", "sway",
    )  # fmt: skip
    width: int = Field(720, ge=8, le=7200, description="columns of the panorama [pixels]")
    height: int = Field(100, ge=4, le=2000, description="rows of the panorama [pixels]")
    camera_height: float = Field(0.6, gt=0, le=3, description="eye level above the floor [m]")
    forward_column: int = Field(360, ge=0, lt=7200, description="recorded column that looks along the nose")
    clockwise: bool = Field(True, description="recorded columns run clockwise")
    codec: Literal["jpeg", "png"] = Field("jpeg", description="image codec of the camera")
    quality: int = Field(90, ge=1, le=100, description="JPEG quality")
    noise: float = Field(2.0, ge=0, le=64, description="sensor noise, standard deviation [grey levels]")
    gain: float = Field(1.0, gt=0, le=8, description="exposure gain; with automatic exposure a correction of it")
    exposure: Literal["fixed", "auto"] = Field("fixed", description="whether the camera sets its gain by the view")
    hour: float | None = Field(None, ge=0, le=24, description="hour of the day that lights the world; none: evenly lit")
    light_changes: tuple[LightChange, ...] = Field((), description="other hours in mid-run")
    horizon_row: float | None = Field(None, ge=0, lt=2000, description="row of eye level; none: mid-image")
    blur: float = Field(0.0, ge=0, le=20, description="blur, standard deviation [pixels]")
    roll_deg: float = Field(0.0, gt=-45, lt=45, description="mount leans to the right by [degree]")
    pitch_deg: float = Field(0.0, gt=-45, lt=45, description="mount leans forward by [degree]")
    missing: float = Field(0.0, ge=0, le=0.9, description="share of frames that don't arrive: no reading at that step")
    repeated: float = Field(0.0, ge=0, le=0.9, description="share of readings that hold the frame before once more")
    lag: float = Field(0.0, ge=0, le=2, description="age of the image at its reading's stamp [s]")
    white_balance: Literal["fixed", "auto"] = Field("fixed", description="whether the camera evens out its colours")
    exposure_lag: float = Field(0.0, ge=0, le=60, description="time constant of exposure and white balance [s]")
    max_bytes: int | None = Field(None, ge=500, le=10**8, description="greatest JPEG; quality falls until it fits [B]")
    hour_rate: float = Field(0.0, ge=0, le=1000, description="hours of the day that pass in an hour of the run")
    lens: LensConfig = Field(default_factory=LensConfig, description="optics")
    shutter: ShutterConfig = Field(default_factory=ShutterConfig, description="motion in the picture")
    sway: SwayConfig = Field(default_factory=SwayConfig, description="tilt by motion and floor")


class LaserConfig(Section):
    """The range scanner."""

    FLAWS = ("dropout", "lag")
    scanner: Literal["ring", "urg", "none"] = Field(
        "ring", description="all round at once, two opposite shots of a scanner, or the camera alone"
    )
    rays: int | None = Field(
        None, ge=1, le=7200, description="ranges per turn that are handed over; none: as many as the camera has columns"
    )
    height: float = Field(0.0, ge=0, le=10, description="only what is at least as high is hit [m]")
    noise: float = Field(0.01, ge=0, le=10, description="range noise, standard deviation [m]")
    max_range: float = Field(10.0, gt=0, le=1000, description="nothing is measured beyond by the ring [m]")
    dropout: float = Field(0.002, ge=0, le=1, description="share of rays that return nothing")
    lag: float = Field(0.0, ge=0, le=2, description="age of the ranges at their reading's stamp [s]")


class OdometerConfig(Section):
    """Errors: forward_read = distance_scale * forward; turn_read = rotation_scale * turn + curvature * forward."""

    FLAWS = ("turn_noise_per_rad_deg", "declared", "slip", "slip_turn_deg", "floor", "floor_patch", "load")
    distance_scale: float = Field(0.95, ge=0.1, le=10, description="distance read per true metre")
    rotation_scale: float = Field(1.04, ge=0.1, le=10, description="turn read per true turn")
    curvature: float = Field(0.003, ge=-10, le=10, description="turn read per true metre, from unequal wheels [rad/m]")
    forward_noise: float = Field(0.02, ge=0, le=10, description="random distance error [m per sqrt m]")
    turn_noise_deg: float = Field(0.5, ge=0, le=180, description="random turn error [degree per sqrt m]")
    turn_noise_per_rad_deg: float = Field(
        0.0, ge=0, le=180, description="random turn error of turns [degree per sqrt rad]"
    )
    declared: float = Field(1.0, ge=0, le=1e4, description="covariance that it declares, times the true one; 0: none")
    slip: float = Field(0.0, ge=0, le=1, description="share of blocked way that spinning wheels read as driven")
    slip_turn_deg: float = Field(0.0, ge=0, le=180, description="random turn read per step in contact [degree]")
    spread: float = Field(
        0.2, ge=0, lt=1, description="each systematic error is multiplied by uniform(1 - spread, 1 + spread)"
    )
    floor: float = Field(0.0, ge=0, le=0.2, description="how the distance read varies by floor, standard deviation")
    floor_patch: float = Field(4.0, ge=0.2, le=100, description="extent of such a floor [m]")
    load: float = Field(
        0.0, ge=0, le=1, description="how each systematic error wanders with load, standard deviation as a share of it"
    )


class BodyConfig(Section):
    """The differential-drive body."""

    radius: float = Field(0.2, ge=0.01, le=2, description="robot radius [m]")
    max_speed: float = Field(0.4, ge=0.01, le=5, description="greatest forward speed [m/s]")
    step: float = Field(0.25, ge=0.01, le=2, description="time from one reading to the next [s]")


class DriverConfig(Section):
    """The driver who teaches the route."""

    route: str = Field("", description="name of the world's route to drive instead of its default one")
    laps: float | None = Field(None, gt=0, le=1000, description="laps to drive instead of the world's own number")
    teaches: bool = Field(True, description="drives the route; if not, the robot has its wheels from the beginning")
    lateral_offset: float = Field(0.0, ge=-10, le=10, description="offset to the left from lap two on [m]")


class StartConfig(Section):
    """Where the robot is set at the beginning: at a place of the world, at x, y, or so far along its route."""

    place: str = Field("", description="name of one of the world's places")
    x: float | None = Field(None, description="where [m]")
    y: float | None = Field(None, description="where [m]")
    along: float | None = Field(None, ge=0, description="way along the route that the driver leaves out [m]")
    heading_deg: float | None = Field(None, description="heading there; none: the place's, or the route's [degree]")

    @model_validator(mode="after")
    def _has_one_place(self) -> Self:
        if (self.x is None) != (self.y is None):
            raise ValueError("give x and y")
        if sum((bool(self.place), self.x is not None, self.along is not None)) > 1:
            raise ValueError("give a place, x and y, or a way along the route, and not two of them")
        return self


class PeopleConfig(Section):
    """People besides those of the world."""

    FLAWS = ("extra", "beside")
    extra: int = Field(0, ge=0, le=200, description="people who walk to and fro along stretches of the robot's route")
    beside: int = Field(0, ge=0, le=20, description="people who walk beside the robot all the way and hide the view")


class MomentConfig(Section):
    """When something happens: at a run time, or so long after the driver has handed over."""

    at_s: float | None = Field(None, ge=0, le=1e6, description="run time [s]")
    handed_over_s: float | None = Field(None, ge=0, le=1e6, description="time since the driver handed over [s]")

    @model_validator(mode="after")
    def _has_one_moment(self) -> Self:
        if (self.at_s is None) == (self.handed_over_s is None):
            raise ValueError("give at_s or handed_over_s, and not both")
        return self


class KidnapConfig(MomentConfig):
    """The robot is carried away, which no wheel notices: to a named place, to x, y, heading, or on along its route."""

    place: str = Field("", description="name of one of the world's places")
    x: float | None = Field(None, ge=-1e5, le=1e5, description="where to [m]")
    y: float | None = Field(None, ge=-1e5, le=1e5, description="where to [m]")
    heading_deg: float = Field(0.0, ge=-360, le=360, description="heading there [degree]")
    along: float | None = Field(
        None, ge=-1e5, le=1e5, description="on along the taught route, below 0 back; it keeps its side [m]"
    )
    turn_deg: float = Field(0.0, ge=-360, le=360, description="and turned on the spot by [degree]")

    @model_validator(mode="after")
    def _has_one_place(self) -> Self:
        ways = bool(self.place), self.x is not None or self.y is not None, self.along is not None
        if sum(ways) > 1 or (self.x is None) != (self.y is None) or not (any(ways) or self.turn_deg):
            raise ValueError("give one of a place, x and y, along; or turn_deg alone")
        return self


class OdometryFaultConfig(MomentConfig):
    """Wheels or encoders that fail for a while; the odometer doesn't know it and reports its usual covariance."""

    lasts_s: float | None = Field(None, gt=0, le=1e6, description="how long [s]; none: to the end")
    forward_scale: float = Field(1.0, ge=-10, le=10, description="the way read is multiplied by this")
    turn_scale: float = Field(1.0, ge=-10, le=10, description="the turn read is multiplied by this")
    forward_noise: float = Field(0.0, ge=0, le=10, description="random way read in each step [m]")
    turn_noise: float = Field(0.0, ge=0, le=3.2, description="random turn read in each step [rad]")
    turn_per_m: float = Field(0.0, ge=-100, le=100, description="turn read besides, for each metre driven [rad/m]")
    jump: float = Field(0.0, ge=-1e4, le=1e4, description="way read once, in its first step [m]")
    jump_turn: float = Field(0.0, ge=-3.2, le=3.2, description="turn read once, in its first step [rad]")


class SimConfig(Section):
    """All of the simulator."""

    FLAWS = ("floor_gloss", "kidnaps", "odometry_faults")
    textures: int = Field(0, ge=0, le=10**6, description="seed of the looks of a world's surfaces")
    camera: CameraConfig = Field(default_factory=CameraConfig, description="panoramic camera")
    laser: LaserConfig = Field(default_factory=LaserConfig, description="range scanner")
    odometer: OdometerConfig = Field(default_factory=OdometerConfig, description="odometer and its errors")
    body: BodyConfig = Field(default_factory=BodyConfig, description="robot body")
    driver: DriverConfig = Field(default_factory=DriverConfig, description="driver of the taught route")
    people: PeopleConfig = Field(default_factory=PeopleConfig, description="people besides the world's own")
    start: StartConfig = Field(default_factory=StartConfig, description="where the robot is set")
    floor_gloss: float | None = Field(None, ge=0, le=1, description="share that the floor mirrors; none: the world's")
    kidnaps: tuple[KidnapConfig, ...] = Field((), description="when and where to the robot is carried away")
    odometry_faults: tuple[OdometryFaultConfig, ...] = Field((), description="when and how the odometry fails")
