"""What the robot is asked to do: be taught a route, then travel to one goal after the other."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field, field_validator

from topomap.core.errors import TopomapError
from topomap.core.records import Goal, Phase, Travel
from topomap.mapping.graph import TopoMap
from topomap.mapping.sessions.places import find
from topomap.navigation.wish import KINDS, Kind, Wish, parse_wish


class MissionSettings(BaseModel, frozen=True, extra="forbid"):
    """What is done, and what is known before it."""

    then: Literal["home", "stop"] = Field("home", description="after teaching: go to the goal node, or end the run")
    goal_node: int = Field(0, ge=0, description="the node to travel to; 0 is where the run began")
    do: str = Field("", description=f"what to do: {KINDS}; none: as `then` says")
    start: str = Field("unknown", description="on a saved map: node or place where the robot is put, or unknown")

    @field_validator("do")
    @classmethod
    def _known(cls, text: str) -> str:
        if text:
            parse_wish(text)
        return text

    @property
    def wish(self) -> Wish:
        """What is asked for."""
        if self.do:
            return parse_wish(self.do)
        return Wish(Kind.TEACH) if self.then == "stop" else Wish(Kind.GOTO, (str(self.goal_node),))


class Mission:
    """Teach while a driver has the wheels, then travel to goal after goal; it failed where one of them was given up.

    failure: why the mission can't be, in one line, or "".
    """

    def __init__(self, settings: MissionSettings) -> None:
        self._wish = settings.wish
        self._phase = Phase.TEACH
        self._goals: list[int] = []
        self._ended = Phase.ARRIVED
        self.failure = ""

    def goal(self, driven: bool, topo: TopoMap) -> Goal:
        """Return the wish of this step."""
        if self._phase is Phase.TEACH and not driven:
            self._phase = self._after_teaching(topo)
        return Goal(self._phase, self._goals[0] if self._phase is Phase.TRAVEL else None)

    def report(self, travel: Travel, able: bool = True) -> None:
        """Take note of what the traveller says: the last goal ends the mission, and one given up by who isn't able.

        able: the robot has its senses and knows where it is, so that another goal may go better.
        """
        if self._phase is not Phase.TRAVEL or travel.phase not in (Phase.ARRIVED, Phase.FAILED):
            return
        if travel.phase is Phase.FAILED:
            self._ended = Phase.FAILED
        if len(self._goals) > 1 and (able or travel.phase is Phase.ARRIVED):
            self._goals.pop(0)
        else:
            self._phase = self._ended

    @property
    def phase(self) -> Phase:
        """What the robot is doing, or how it ended."""
        return self._phase

    @property
    def over(self) -> bool:
        """Whether nothing is left to do."""
        return self._phase in (Phase.ARRIVED, Phase.FAILED)

    def _after_teaching(self, topo: TopoMap) -> Phase:
        if self._wish.kind is Kind.TEACH:
            return Phase.ARRIVED
        try:
            self._goals = goals_of(self._wish, topo)
        except TopomapError as error:
            self.failure = str(error)
            return Phase.FAILED
        return Phase.TRAVEL


def goals_of(wish: Wish, topo: TopoMap) -> list[int]:
    """Return the nodes to travel to. Raises TopomapError for one that the map hasn't, or that holds no view."""
    if wish.kind in (Kind.HOME, Kind.HALL):
        return [topo.chain[0]]
    return [find(topo, target) for target in wish.targets]
