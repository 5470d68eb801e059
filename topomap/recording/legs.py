"""The legs of a run: one for each goal that the robot was sent to."""

from __future__ import annotations

from collections.abc import Sequence

from logs import records as log
from topomap.core.records import Phase
from topomap.core.run_data import Leg

CLAIMED: dict[str, bool] = {Phase.ARRIVED: True, Phase.FAILED: False}


def legs(missions: Sequence[log.Mission]) -> tuple[Leg, ...]:
    """Return the legs of the steps' missions; a leg ends where the robot arrives, gives up or gets another goal."""
    begun: list[list[int]] = []
    ended = True
    for step, mission in enumerate(missions):
        if mission.goal is None:
            ended = True
            continue
        if ended or missions[begun[-1][-1]].goal != mission.goal:
            begun.append([])
        begun[-1].append(step)
        ended = mission.travel in (Phase.ARRIVED, Phase.FAILED)
    return tuple(_leg(steps, [missions[step] for step in steps]) for steps in begun)


def _leg(steps: Sequence[int], missions: Sequence[log.Mission]) -> Leg:
    end = missions[-1]
    assert end.goal is not None
    return Leg(end.goal, steps[0], steps[-1], CLAIMED.get(end.travel), milestones(missions))


def milestones(missions: Sequence[log.Mission]) -> tuple[int, ...]:
    """Return the milestones in the order in which they were first steered for."""
    return tuple(dict.fromkeys(one.milestone for one in missions if one.milestone is not None))
