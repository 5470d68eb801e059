"""How the back end weighs closures."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class BackendSettings(BaseModel):
    """Graduated non-convexity for closures; cutoffs are in sigmas of the closure."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    cutoff: float = Field(
        default=3.4,
        gt=0,
        le=100,
        description="closures further off aren't believed [sigmas; 3.4: 99 % at 3 dof]",
    )
    widest: float = Field(
        default=64.0, gt=0, le=1e6, description="the annealing starts at most here [sigmas]"
    )
    shrink: float = Field(
        default=1.6, gt=1, le=10, description="an iteration divides the annealed cutoff by this"
    )
    iterations: int = Field(default=10, ge=1, le=100, description="iterations at most, after the annealing")
    tolerance: float = Field(default=1e-3, gt=0, description="largest step [m, rad] when it has converged")
    turn_cutoff: float = Field(
        default=3.0, gt=0, le=100, description="seen turns further off fade out [sigmas]"
    )
