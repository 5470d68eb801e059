"""Settings of the back end: outlier cutoffs, annealing, convergence."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from topomap.mapping.uncertainty.agreement import SupportSettings


class OptimizerSettings(BaseModel):
    """Graduated non-convexity for closures; cutoffs are in sigmas of the closure."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    cutoff: float = Field(
        default=3.4, gt=0, le=100, description="a closure further off is an outlier [sigmas; 99 % at 3 dof]"
    )
    cutoffs: tuple[float, ...] = Field(
        default=(), description="annealed cutoffs [sigmas]; none: begin with what odometry allows"
    )
    stages: int = Field(default=10, ge=0, le=100, description="annealing stages at most")
    shrink: float = Field(default=2.0, gt=1, le=10, description="a stage divides what odometry may be off by this")
    iterations: int = Field(default=10, ge=1, le=100, description="iterations at most, after the annealing")
    tolerance: float = Field(default=1e-3, gt=0, description="largest step [m, rad] when it has converged")
    turn_cutoff: float = Field(
        default=3.0,
        gt=0,
        le=100,
        description="measured turns fade out beyond this [sigmas of turn and odometry together]",
    )
    support: SupportSettings = Field(default_factory=SupportSettings, description="agreement that seeds a solve")
