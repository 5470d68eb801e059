"""What the robot is asked to do: be taught a route, then travel to a goal."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from topomap.core.records import Goal, Phase, Travel
from topomap.mapping.graph import TopoMap


class MissionSettings(BaseModel, frozen=True, extra="forbid"):
    """What follows the taught route."""

    then: Literal["home", "stop"] = Field("home", description="after teaching: go to the goal node, or end the run")
    goal_node: int = Field(0, ge=0, description="the node to travel to; 0 is where the run began")


class Mission:
    """Teach while a driver has the wheels, then travel until the goal is reached or given up."""

    def __init__(self, settings: MissionSettings) -> None:
        self._settings = settings
        self._phase = Phase.TEACH

    def goal(self, driven: bool, topo: TopoMap) -> Goal:
        """Return the wish of this step."""
        if self._phase is Phase.TEACH and not driven:
            self._phase = self._after_teaching()
        node = min(self._settings.goal_node, len(topo.nodes) - 1) if self._phase is Phase.TRAVEL else None
        return Goal(self._phase, node)

    def report(self, travel: Travel) -> None:
        """Take note of what the traveller says; an arrival or a failure ends the mission."""
        if travel.phase in (Phase.ARRIVED, Phase.FAILED):
            self._phase = travel.phase

    @property
    def phase(self) -> Phase:
        """What the robot is doing, or how it ended."""
        return self._phase

    @property
    def over(self) -> bool:
        """Whether nothing is left to do."""
        return self._phase in (Phase.ARRIVED, Phase.FAILED)

    def _after_teaching(self) -> Phase:
        return Phase.TRAVEL if self._settings.then == "home" else Phase.ARRIVED
