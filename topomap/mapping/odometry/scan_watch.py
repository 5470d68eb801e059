"""Whether some steps' odometry can be true: the ranges after them laid over the ranges before them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.mapping.odometry.company import Company
from topomap.mapping.odometry.seen_way import seen_way
from topomap.vision.image.compare import rotation_difference, signature
from topomap.vision.matching.scan_match import match_scans

STEPS = 5
"""Steps from one look to the next: half a metre, over which ranges overlap and the odometer's error is small."""
WAY_OFF, WAY_SHARE, TURN_OFF = 0.15, 0.3, math.radians(8.0)
"""[m], share of the way, [rad] by which odometry and ranges differ, one of the first two or the third, before it isn't
believed: undisturbed, with an uncorrected scale 5 % off, they differ by 0.06 m of 0.5 and by 2.5 degrees at most in
five worlds, people included."""
SEEN_OFF = 0.2
"""[m] The same where views tell the way: undisturbed they differ from the odometry by 0.09 m at most in 999 of 1,000
looks in six worlds, and in 8 of some 3,000 between walls a metre off (`campus`) by 0.15 to 0.18."""
STOOD = 4
"""Steps, of those from one look to the next, in which the wheels count nothing though the view moves: people who pass
hide it for two or three."""
FAR_ENOUGH = 0.3
"""Share of the usual way that ranges must show where the view moves."""
EXACT, EXACT_TURN = 0.05, math.radians(1.0)
"""[m], [rad] Greatest errors of what is believed: along bare corridors ranges don't tell the way, but views do."""


class ScanWatch:
    """Lays every fifth scan over the one five steps before it.

    Along corridors, which ranges don't tell, the views have to be those predicted there.
    untrue: whether the odometry of late wasn't what these show; turn_untrue: whether its turn wasn't, either; said:
    about the last step, "" for nothing.
    """

    def __init__(self) -> None:
        self.untrue = self.turn_untrue = False
        self.said = ""
        self.sees = False
        self._view: Panorama | None = None
        self.company = Company()
        self._slack = Pose2()  # where the ranges showed the robot at the last look, seen from where it was believed
        self._restart(None)

    @property
    def pending(self) -> bool:
        """Whether ranges showed a robot that stands, not yet often enough."""
        return self.company.nothing_moved and not self.untrue

    def _restart(self, panorama: Panorama | None) -> None:
        self._view, self._read, self._believed = panorama, Pose2(), Pose2()
        self._steps, self._stood, self._moved = 0, 0, False

    def begin(self, panorama: Panorama) -> None:
        """Begin anew with a view: what was before it isn't compared with."""
        self.untrue, self.turn_untrue, self.said, self._slack = False, False, "", Pose2()
        self.company = Company()
        self._restart(panorama)

    def step(
        self, panorama: Panorama, read: Pose2, believed: Pose2, usual: float, stood: bool, moves: bool
    ) -> Pose2 | None:
        """Take a step as the odometry has it and as it is believed; usual: way of a step [m]; stood: the wheels count
        nothing, though the view moves; moves: the view does.

        Returns what this step is to be believed as, so that all since the last look are where the ranges show them;
        None: as it was.
        """
        self.said = ""
        before = self._believed
        self._steps, self._read, self._believed = self._steps + 1, self._read @ read, before @ believed
        self._stood += stood
        self._moved = self._moved or moves
        if self._view is None or self._view.ranges is None:
            self._restart(panorama)
            return None
        if panorama.ranges is None or self._steps < STEPS:
            return None
        found = self._found(self._view, panorama, usual)
        self.sees = found is not None
        seen = None
        if not self._goes_along(found, self._view, panorama, usual):
            seen = self._judge(found)
        elif found is not None:
            self._wait(found)
        self._restart(panorama)
        return None if seen is None else before.to(seen)

    def _found(self, before: Panorama, now: Panorama, usual: float) -> Shown | None:
        """Return where the ranges show the robot, seen from the last look, by the odometry or else by another guess."""
        assert before.ranges is not None
        assert now.ranges is not None
        own = _match(before.ranges, now.ranges, self._read)
        fits = own is not None and not self._off(own)
        if own is not None and fits and len(own.told) == 2:
            return own
        least = FAR_ENOUGH * STEPS * usual if self._moved else 0.0  # else it is the ranges that stand still
        every = [_match(before.ranges, now.ranges, guess) for guess in self._guesses(before, now, usual)]
        others = [one for one in every if one is not None and math.hypot(one.pose.x, one.pose.y) >= least]
        best = max(others, key=lambda one: (len(one.told), one.share), default=None)
        shown = own if fits and (best is None or len(best.told) < 2) else best
        return shown if shown is None or len(shown.told) == 2 else self._with_view(shown, before, now, usual)

    def _with_view(self, shown: Shown, before: Panorama, now: Panorama, usual: float) -> Shown:
        """Let the views tell the direction that ranges don't, where they contradict the odometry in it."""
        assert before.ranges is not None
        assert now.ranges is not None
        along = np.array([-shown.told[0, 1], shown.told[0, 0]])
        read = float(along @ self._read.array()[:2])
        if np.array_equal(before.ranges, now.ranges, equal_nan=True):
            return shown  # the scanner repeats itself: its distances are none of the view's
        if read < 0.0:
            along, read = -along, -read
        way = seen_way(before, now, shown.pose, along, read, STEPS * usual)
        if way == read:
            return shown
        x, y = shown.pose.array()[:2] + (way - float(along @ shown.pose.array()[:2])) * along
        pose = Pose2(float(x), float(y), shown.pose.heading)
        return Shown(pose, np.vstack([shown.told, along]), shown.share, "ranges and views show", SEEN_OFF)

    def _guesses(self, before: Panorama, now: Panorama, usual: float) -> Iterator[Pose2]:
        turn = rotation_difference(signature(now), signature(before))[1]
        way = STEPS * usual
        yield Pose2(way * math.cos(turn / 2), way * math.sin(turn / 2), turn)
        if not self._moved:
            yield Pose2(0.0, 0.0, turn)
        if self.untrue:
            yield self._believed

    def _off(self, shown: Shown) -> bool:
        """Return whether the odometry isn't what ranges show, in the directions that they tell."""
        if len(shown.told) < 2 and self._stood >= (1 if self.untrue else STOOD):
            return True  # along a corridor ranges can't tell wheels that count nothing, but the view can
        seen = shown.pose
        away = np.abs(shown.told @ (seen.array()[:2] - self._read.array()[:2])).max(initial=0.0)
        much = max(shown.off, WAY_SHARE * math.hypot(seen.x, seen.y))
        return bool(away > much) or self._turn_off(shown)

    def _goes_along(self, shown: Shown | None, before: Panorama, now: Panorama, usual: float) -> bool:
        """Return whether what shows less way than the odometry reads goes along with the robot, as people may."""
        way = math.hypot(self._read.x, self._read.y)
        if shown is None or math.hypot(shown.pose.x, shown.pose.y) >= way or not self._off(shown):
            self.company.pass_by()
            return False
        return self.company.explains(before, now, self._read, shown.pose, STEPS * usual)

    def _turn_off(self, shown: Shown) -> bool:
        return abs(wrap(shown.pose.heading - self._read.heading)) > TURN_OFF

    def _wait(self, shown: Shown) -> None:
        """Believe the odometry for now: should the robot prove to stand, all of it is taken back; in company, where it
        is less sure, the last look's alone."""
        alone = self.company.nothing_moved and not self.company.present
        self._slack = self._slack @ self._believed.to(shown.pose) if alone else Pose2()
        self.untrue = self.turn_untrue = False

    def _judge(self, shown: Shown | None) -> Pose2 | None:
        """Return where the robot is since the last look where that isn't what is believed."""
        if shown is None:
            self._slack = Pose2()
            return None
        before, self.untrue = self.untrue, self._off(shown)
        self.turn_untrue = self.untrue and (self._stood > 0 or self._turn_off(shown))
        seen = shown.pose
        slack, self._slack = self._slack, self._believed.to(seen)
        if self.untrue and not before:
            self.said = (
                f"odometry untrue: it counts {_words(self._read)} where {shown.how} {_words(seen)}; these are taken"
            )
        if not self.untrue and not before:
            return None
        self._slack = Pose2()
        return slack @ seen  # it failed before it was noticed


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """A pose by ranges; told (K, 2): unit vectors of the directions that they tell; share of rays with a partner; how:
    what shows it, in words; off [m]: how far from it the odometry may be.
    """

    pose: Pose2
    told: FloatArray
    share: float
    how: str = "the ranges show"
    off: float = WAY_OFF


def ranges_confirm(before: Panorama, now: Panorama, read: Pose2, share: float = 0.0) -> bool:
    """Return whether ranges show, in both directions, the step that the odometry reads; share: of rays, at least."""
    if before.ranges is None or now.ranges is None or np.array_equal(before.ranges, now.ranges, equal_nan=True):
        return False
    shown = _match(before.ranges, now.ranges, read)
    if shown is None or len(shown.told) < 2 or shown.share < share:
        return False
    off = read.to(shown.pose)
    return math.hypot(off.x, off.y) <= WAY_OFF and abs(off.heading) <= TURN_OFF


def share_of(before: Panorama, now: Panorama, read: Pose2) -> float:
    """Return the share of rays that show the step that the odometry reads, 0 where too few do."""
    if before.ranges is None or now.ranges is None:
        return 0.0
    shown = _match(before.ranges, now.ranges, read)
    return 0.0 if shown is None else shown.share


def _match(before: Float32Array, now: Float32Array, guess: Pose2) -> Shown | None:
    """Return a pose whose turn the ranges tell, and its way in one direction at least, or None."""
    match = match_scans(before, now, guess.array())
    if match is None or not np.isfinite(match.covariance).all() or match.covariance[2, 2] > EXACT_TURN**2:
        return None
    values, directions = np.linalg.eigh(match.covariance[:2, :2])
    told = directions.T[np.sqrt(np.abs(values)) <= EXACT]
    return Shown(Pose2.of(match.relative), told, match.share) if len(told) else None


def _words(pose: Pose2) -> str:
    return f"{math.hypot(pose.x, pose.y):.2f} m and {math.degrees(pose.heading):.0f} degrees"
