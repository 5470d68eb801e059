"""How a drive whose claims say only "the same place" is mapped."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from topomap.mapping.optimizer import OptimizerSettings
from topomap.mapping.uncertainty.agreement import SupportSettings


def _growing() -> OptimizerSettings:
    return OptimizerSettings(cutoffs=(16.0, 8.0, 4.0, 2.0), cutoff=1.5, iterations=2, tolerance=0.05)


def _closing() -> OptimizerSettings:
    return OptimizerSettings(cutoffs=(3.0, 2.0, 1.5), cutoff=1.0)


class GateSettings(BaseModel):
    """When odometry contradicts a closure."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    probability: float = Field(default=0.99, gt=0.5, lt=1, description="share of true closures the gate lets pass")


class AlongSettings(BaseModel):
    """Stages and their limits; none was chosen on a recording's truth."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    min_way: float = Field(default=5.0, ge=0, description="pairs with less way between say nothing [m]")
    min_support: float = Field(
        default=0.25,
        ge=0,
        description="summed similarity of agreeing neighbours, in units of what all neighbours of a loop sum up to",
    )
    support: SupportSettings = Field(default_factory=SupportSettings, description="which neighbours agree")
    gate: GateSettings = Field(default_factory=GateSettings, description="when odometry contradicts")
    closure_sigma: float = Field(default=1.0, gt=0, description="how far apart the places of a loop lie [m]")
    every: float = Field(default=25.0, gt=0, description="way between two solves [m]")
    growing: OptimizerSettings = Field(default_factory=_growing, description="the solve every so often")
    readmit: float = Field(default=3.0, gt=0, description="the last solve hears all loops this near [m]")
    closing: OptimizerSettings = Field(default_factory=_closing, description="the last solve")
    start_curvature: float = Field(default=0.0, ge=-0.1, le=0.1, description="curvature at start [rad/m]")
    min_believed: float = Field(
        default=0.2, ge=0, le=1, description="share of supported loops below which other curvatures are tried"
    )
    chance: float = Field(
        default=1e-8, ge=0, le=1, description="probability that false loops fit so well above which none is believed"
    )
    building_axes: bool = Field(default=False, description="straight stretches run along the building's axes")
    axis_sigma_deg: float = Field(default=3.0, gt=0, le=45, description="how straight a corridor is driven [degree]")
    straight: float = Field(default=3.0, gt=0, description="way over which a stretch is straight [m]")
    rotation_sigma: float = Field(default=0.05, gt=0, description="prior sigma of the log rotation scale")
    curvature_sigma: float = Field(default=0.01, gt=0, description="prior sigma of the curvature [rad/m]")
    distance_sigma: float = Field(default=0.1, gt=0, description="prior sigma of the distance scale")
