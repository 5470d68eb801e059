"""Where a lost robot heads: along the way its map says it will know soonest, or as it looks."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2, between, compose
from topomap.core.records import Hypothesis, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation.search.deliberation import Deliberation
from topomap.navigation.search.parting import Parting
from topomap.navigation.search.stops import stops_from

LED, KNOWN = 0.15, 0.35
"""Weight of the likeliest place, and of all that are told together, from which on a way is chosen: where the robot may
be anywhere, no way is better."""
RIVAL, OPEN = 0.1, 0.01
"""Weight of a rival that counts, over that of the likeliest one; and of all that count, below which nothing is open."""
STOPS = 3
"""Stops looked at in a step: 25 ms each, so that a choice takes up to 20 steps and no step much longer."""
BEFORE = 1.3
"""[m] Way of a search before the first choice: a stretch and a look, before which one view alone has spoken."""
AGAIN = 4.0
"""[m] Way after which it is chosen anew, or ..."""
SOONER, ELSEWHERE = 1.0, 2.0
"""[m] ... after this way, where another place leads, or one counts that lies so far from where those weighed would be
by now."""
AIM, OFF = 1.0, 1.5
"""[m] The robot heads for the way's next point so far off; farther beside the way it has left it."""
STUCK = 60
"""Steps without getting on, after which the way is left: 15 s."""
TRAIL = 0.7
"""[m] Stops nearer than this to where the robot has been tell nothing that hasn't spoken yet."""


class SearchWay:
    """Chooses a way now and then, a few stops a step, and follows it by odometry."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget a search that has ended."""
        self._deliberation: Deliberation | None = None
        self._raw, self._here, self._weighed = Pose2(), Pose2(), np.zeros((1, 3))
        self._began_at, self._chosen_at = math.inf, -math.inf
        self._points: FloatArray | None = None
        self._trail = list[tuple[float, float]]()
        self._stood, self._moved_at = 0, 0.0

    def step(self, where: Where, mapper: Mapper) -> tuple[float | None, str]:
        """Return the bearing [rad] of the chosen way, None where the robot goes as it looks, and what was decided."""
        raw = mapper.track.raw
        self._began_at = min(self._began_at, mapper.track.travel)
        if not self._trail or math.dist(self._trail[-1], (raw.x, raw.y)) > TRAIL / 2:
            self._trail.append((raw.x, raw.y))
        if self._deliberation is None and self._is_due(where, mapper):
            self._begin(where, mapper)
        return self._bearing(mapper), self._decide(mapper)

    def _is_due(self, where: Where, mapper: Mapper) -> bool:
        led = 1.0 - where.lost
        known = led + sum(rival.weight for rival in where.rivals)
        if mapper.track.travel - self._began_at < BEFORE or led < LED or known < KNOWN:
            return False
        since = mapper.track.travel - self._chosen_at
        return since >= AGAIN or (since >= SOONER and self._is_news(where, mapper))

    def _is_news(self, where: Where, mapper: Mapper) -> bool:
        """Return whether another place leads than in the last choice, or one counts that it didn't weigh."""
        now = compose(self._weighed, between(self._raw.array(), mapper.track.raw.array()))
        if math.dist(now[0, :2], (where.pose.x, where.pose.y)) > ELSEWHERE:
            return True
        places = np.array([[rival.pose.x, rival.pose.y] for rival in _weighty(where)]).reshape(-1, 2)
        away = np.hypot(*(places[:, None] - now[None, :, :2]).transpose(2, 0, 1))
        return bool((away.min(axis=1) > ELSEWHERE).any())

    def _begin(self, where: Where, mapper: Mapper) -> None:
        rivals = _weighty(where)
        if not rivals:
            return
        self._weighed = np.array([where.pose.array(), *(rival.pose.array() for rival in rivals)])
        self._raw, self._here, self._chosen_at = mapper.track.raw, where.pose, mapper.track.travel
        ways = stops_from(mapper.map, mapper.recognition.nodes()[: mapper.located], where.pose)
        trail = np.array(self._trail)
        spots = self._by_odometry(mapper, [stop.node for stop in ways.stops])
        seen = (np.hypot(*(spots[:, None] - trail[None]).transpose(2, 0, 1)) < TRAIL).any(axis=1)
        parting = Parting(mapper, where.pose, self._weighed[1:])
        self._deliberation = Deliberation(ways, np.array([rival.weight for rival in rivals]), parting, seen)

    def _decide(self, mapper: Mapper) -> str:
        """Go on thinking; return what was decided, "" for nothing."""
        choice = self._deliberation.step(STOPS) if self._deliberation is not None else None
        if choice is None:
            return ""
        self._deliberation, self._stood, self._moved_at = None, 0, mapper.track.travel
        self._points = self._by_odometry(mapper, list(choice.path)) if choice.path else None
        return choice.why

    def _by_odometry(self, mapper: Mapper, nodes: list[int]) -> FloatArray:
        """Return where nodes (n, 2) lie in the odometry's frame, if the robot is where the choice took it to be."""
        c, s = math.cos(self._raw.heading - self._here.heading), math.sin(self._raw.heading - self._here.heading)
        off = mapper.map.poses[nodes, :2] - np.array([self._here.x, self._here.y])
        turned: FloatArray = off @ np.array([[c, s], [-s, c]]) + np.array([self._raw.x, self._raw.y])
        return turned

    def _bearing(self, mapper: Mapper) -> float | None:
        if self._points is None:
            return None
        raw, travel = mapper.track.raw, mapper.track.travel
        self._stood += 1
        if travel - self._moved_at > 0.3:
            self._stood, self._moved_at = 0, travel
        away = np.hypot(self._points[:, 0] - raw.x, self._points[:, 1] - raw.y)
        k = int(np.argmin(away))
        ahead = np.flatnonzero(away[k:] >= AIM)
        if not len(ahead) or away[k] > OFF or self._stood > STUCK:
            self._points = None
            return None
        x, y = self._points[k + int(ahead[0])]
        return raw.bearing_to(Pose2(float(x), float(y)))


def _weighty(where: Where) -> list[Hypothesis]:
    """Return the rivals that count."""
    most = max((rival.weight for rival in where.rivals), default=0.0)
    found = [rival for rival in where.rivals if rival.weight >= RIVAL * most]
    return found if sum(rival.weight for rival in found) >= OPEN else []
