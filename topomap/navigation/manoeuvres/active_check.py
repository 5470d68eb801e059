"""The active check of an undecided closure: home a short way to its snapshot and see whether the views grow alike."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Candidate, Command, Phase, Travel
from topomap.mapping.closures.ledger import key_of
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation.pilot import Pilot
from topomap.vision.contracts import Aligner
from topomap.vision.image.aligned_difference import aligned_difference

WAY = 0.6
"""[m] Longest way that is homed, and that a candidate may lie behind: over it the difference doubles or more in all
worlds looked at (0.17 to 0.37 at 0.1 m, 0.54 to 1.02 at 0.5 m)."""
SPEED = 0.2
"""[m/s] Limit meanwhile: a view every 5 cm."""
STEPS = 40
"""Steps after which the check is given up: three times what the way takes at this speed and 0.25 s a step."""
APART = 0.03
"""[m] Way between two views that are compared: nearer ones differ by about what pixel noise makes."""
VIEWS = 5
"""Views without which nothing is said: four show such a trend by chance in one case of six, five in one of nine."""
TREND = 0.6
"""Kendall's tau of difference and way from which on it has a trend: ten views show it by chance once in a hundred."""
FALL = 0.8
"""Share of its start below which the difference has fallen: far more than pixel noise, 0.01, takes off."""


class ActiveSettings(BaseModel, frozen=True, extra="forbid"):
    """Whether a pending closure is checked by homing."""

    on: bool = Field(False, description="check pending closures by homing a short way, while the stack steers")


class _Approach:
    """One check: the candidate, the snapshots that may be homed to, and the differences seen on the way to one."""

    def __init__(self, candidate: Candidate, goals: list[int], rotation: float, travel: float) -> None:
        self.candidate, self.goals = candidate, goals
        self.rotation = rotation  # the robot's heading minus the candidate's match's
        self.began = travel
        self.steps = 0
        self.seen: list[tuple[float, float]] = []  # way [m], difference


class ActiveCheck:
    """Takes the wheels for one pending candidate at a time, once for each, and tells the mapper what it saw.

    homing: the traveller's own `AlignedHoming`, or any aligner that gives home vectors as well.
    """

    def __init__(self, settings: ActiveSettings, pilot: Pilot, homing: Aligner) -> None:
        self._s = settings
        self._pilot, self._homing = pilot, homing
        self._approach: _Approach | None = None
        self._tried: set[tuple[int, int]] = set()

    def step(self, panorama: Panorama, contact: bool, mapper: Mapper) -> tuple[Command, Travel] | None:
        """Return the command and what was done, or None where there is nothing to check."""
        if not self._s.on:
            return None
        self._approach = self._approach or self._begin(mapper)
        if self._approach is None:
            return None
        return self._follow(self._approach, panorama, contact, mapper)

    def _begin(self, mapper: Mapper) -> _Approach | None:
        """Start with the newest candidate that is pending, not far behind and untried."""
        track, topo = mapper.track, mapper.map
        for candidate in reversed(mapper.ledger.pending):
            assert candidate.query is not None
            near = track.travel - topo.nodes[candidate.query].travel <= WAY
            if near and key_of(candidate) not in self._tried:
                self._tried.add(key_of(candidate))
                turned = track.pose.heading - topo.pose(candidate.query).heading - track.turn
                rotation = wrap(candidate.relative.heading + turned)
                return _Approach(candidate, _goals(candidate.match, topo), rotation, track.travel)
        return None

    def _follow(self, approach: _Approach, panorama: Panorama, contact: bool, mapper: Mapper) -> tuple[Command, Travel]:
        """Look, then go on homing or end the check."""
        approach.steps += 1
        goal = approach.goals[0]
        view = mapper.view_cache.panorama(goal)
        aside = _heading(approach.candidate.match, mapper) - _heading(goal, mapper)
        alignment = self._homing.align(panorama, view, wrap(approach.rotation + mapper.track.turn + aside))
        approach.rotation = wrap(alignment.rotation - aside)
        difference = aligned_difference(panorama, view, alignment.rotation)
        way = mapper.track.travel - approach.began
        if not approach.seen or way - approach.seen[-1][0] >= APART:
            approach.seen.append((way, difference))
        travel = Travel(Phase.TRAVEL, goal, alignment.home, difference, note="active check")
        home = alignment.home
        if home is None or home.confidence <= 0:
            return self._from_here(approach, mapper, travel)
        if contact:
            return self._end(approach, mapper, travel, "contact")
        command = self._pilot.steer(home.bearing, panorama.ranges, SPEED)
        if command != self._pilot.steer(home.bearing, None, SPEED):
            return self._end(approach, mapper, travel, "something stands in the way")
        if way >= WAY or approach.steps >= STEPS or self._fallen(approach):
            return self._end(approach, mapper, travel, "")
        return command, travel

    def _from_here(self, approach: _Approach, mapper: Mapper, travel: Travel) -> tuple[Command, Travel]:
        """Where the way home can't be seen, as at the place itself, home to the snapshot beside it instead."""
        if self._fallen(approach) or len(approach.goals) < 2:
            return self._end(approach, mapper, travel, "no home vector")
        approach.goals.pop(0)
        approach.seen.clear()
        approach.began = mapper.track.travel
        return Command(), travel

    def _end(self, approach: _Approach, mapper: Mapper, travel: Travel, obstacle: str) -> tuple[Command, Travel]:
        """Stop, and tell the mapper what the views say; where they say nothing the candidate goes on waiting."""
        self._approach = None
        start, end = approach.seen[0][1], approach.seen[-1][1]
        told = f"active check: homing {approach.seen[-1][0]:.2f} m took the difference from {start:.2f} to {end:.2f}"
        if self._fallen(approach):
            mapper.testify(approach.candidate, True, told)
        elif not obstacle and self._risen(approach):
            mapper.testify(approach.candidate, False, told)
        else:
            told = f"active check: undecided ({obstacle or told})"
        note = f"{told} [node {approach.goals[0]}]"
        return Command(), Travel(travel.phase, travel.milestone, travel.home, travel.difference, note=note)

    def _fallen(self, approach: _Approach) -> bool:
        differences = [difference for _, difference in approach.seen]
        return self._trend(differences) <= -TREND and differences[-1] <= FALL * differences[0]

    def _risen(self, approach: _Approach) -> bool:
        differences = [difference for _, difference in approach.seen]
        return self._trend(differences) >= TREND and differences[-1] > differences[0]

    def _trend(self, differences: list[float]) -> float:
        """Return Kendall's tau of differences in the order they were seen, in [-1, 1]; 0 where they are too few."""
        if len(differences) < VIEWS:
            return 0.0
        return float(np.mean([np.sign(later - earlier) for earlier, later in combinations(differences, 2)]))


def _goals(match: int, topo: TopoMap) -> list[int]:
    """Return a candidate's node and the snapshots next to it on the way, the later one first."""
    after = next((k for k in range(match + 1, len(topo.nodes)) if topo.nodes[k].snapshot is not None), None)
    before = next((k for k in range(match - 1, -1, -1) if topo.nodes[k].snapshot is not None), None)
    return [match, *(k for k in (after, before) if k is not None)]


def _heading(node: int, mapper: Mapper) -> float:
    return mapper.map.pose(node).heading
