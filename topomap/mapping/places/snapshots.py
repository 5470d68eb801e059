"""When a view has changed enough to be kept as a snapshot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from pydantic import BaseModel, Field, field_validator

from topomap.core.errors import DataError
from topomap.core.view_size import parse_view


class SnapshotSettings(BaseModel, frozen=True, extra="forbid"):
    """When to store a snapshot."""

    rule: Literal["change", "accumulated"] = Field(
        "change", description="difference to the last snapshot, or the thesis's accumulated difference"
    )
    threshold: float = Field(0.8, gt=0, description="image difference that asks for a snapshot (rms, z-normalised)")
    min_travel: float = Field(0.25, ge=0, description="least way between snapshots [m]")
    max_travel: float = Field(1.0, gt=0, description="longest way between snapshots [m]")
    view: str = Field("full", description="what is kept: full, or columns x rows x bits of grey as 90x12x4 or 72x10x3")

    @field_validator("view")
    @classmethod
    def _known(cls, text: str) -> str:
        try:
            parse_view(text)
        except DataError as error:
            raise ValueError(str(error)) from error
        return text


@dataclass(frozen=True, slots=True)
class View:
    """What a rule looks at: rotation-minimised difference to the last snapshot and to the previous view, way since
    the last snapshot [m]."""

    to_snapshot: float
    to_previous: float
    travelled: float


class SnapshotRule(Protocol):
    """Decides step by step; returns the reason for a snapshot or None."""

    def judge(self, view: View) -> str | None: ...


class ChangeRule:
    """Keep when the view differs enough from the last snapshot: a parked robot never spawns snapshots."""

    def __init__(self, settings: SnapshotSettings) -> None:
        self._s = settings

    def judge(self, view: View) -> str | None:
        """Return "view changed", "far" or None."""
        if view.travelled < self._s.min_travel:
            return None
        if view.to_snapshot > self._s.threshold:
            return "view changed"
        return "far" if view.travelled >= self._s.max_travel else None


class AccumulatedRule:
    """The thesis's rule (5.2.4): keep when the differences between neighbouring views add up to the threshold.

    A baseline: it counts noise as change, so a parked robot spawns snapshots.
    """

    def __init__(self, settings: SnapshotSettings) -> None:
        self._s = settings
        self._sum = 0.0

    def judge(self, view: View) -> str | None:
        """Return "differences added up" or None."""
        self._sum += view.to_previous
        if self._sum <= self._s.threshold:
            return None
        self._sum = 0.0
        return "differences added up"


def make_rule(settings: SnapshotSettings) -> SnapshotRule:
    """Return a fresh rule of the settings."""
    return ChangeRule(settings) if settings.rule == "change" else AccumulatedRule(settings)
