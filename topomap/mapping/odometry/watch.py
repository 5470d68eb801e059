"""Whether a step's odometry can be true: the view after it against the view before it."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Motion
from topomap.core.robot import MotionReading
from topomap.mapping.odometry.gap import Restated
from topomap.mapping.odometry.increments import Calibration, advance
from topomap.mapping.odometry.leaps import Leaps
from topomap.mapping.odometry.scan_watch import STEPS, ScanWatch, ranges_confirm, share_of
from topomap.mapping.odometry.usual_change import MEMORY, TIMES, UsualChange
from topomap.mapping.odometry.view_change import LEAST, seen_turn, structure_change, view_change

TURN_WAY = 0.2
"""[m] Way that changes a view as much as turning by one radian on the spot does."""
MOVING = 0.5
"""Share of the usual change from which on a view moves although the wheels stand."""
UNMOVED = 0.2
"""Share of the usual change up to which a view stands still."""
PATIENCE = 4
"""Steps in a row in which wheels and view contradict one another: people who pass do so for two or three."""
LIT, LIT_MOST = 2.0, 0.45
"""Times the usual change without light, and change without light, up to which it is the light that changed. Undisturbed
views change by up to 1.6 times it, carried on by a metre by 2.2 (`warehouse`), 3.8 (`office-loop`, room, hall) or more;
from morning to noon in one step by 1.3 to 1.8, in 95 of 100, and by 2.6 in `hall`. Photographs of other places differ
by 0.6 in a park, where 0.15 is usual."""
LIT_STILL = 0.6
"""The same where ranges show the step that the odometry reads: from noon to night views change by 0.57 at most in 95
of 100 in `hall` and room; other places look otherwise by 0.85 in rooms, by 0.64 in `hall`."""
LIT_SHARE = 0.8
"""... by so many rays, of those that showed the step before: from one step to the next 0.77 to 1 in 99 of 100, people
included. Carried on by 4.4 m along a wall of `hall` the wall alone fits, 0.26 of the rays for 0.39."""
QUICKER = 2.0
"""Times the quickest turn so far, or BRISK, beyond which a turn that no view shows is the odometer's and no frame that
the camera repeats: odometry that errs by 0.3 rad a step of 0.25 s reads 4 rad/s."""
BRISK = 0.6
"""[rad/s] A turn that any robot may make though it hasn't so far: a corner begins with 0.04, 0.12, 0.26, 0.34, and a
reading after missing frames spans several steps of it."""
SHORTEST = 0.01
"""[s] A driver may say that a step took no time at all."""
SEEN_WAY, SEEN_TURN = 0.05, math.radians(3.0)
"""[m], [rad] Error of a step restated by what is usual and by the view; undisturbed, a view's turn is at most 2.8
degrees off the odometry's in four worlds, up to 4.9 (sd 1.5) between walls a metre off, and much the same in the next
step: so it stands in only for a turn that can't be true."""
LESS_ALIKE = 1.5
"""Times that the views are less alike at the turn that a leaping odometer reads than at the one between them, from
which on that turn isn't true either: in a park's photographs 1.16, where it read -12 degrees and they showed -20; it
was right, and the map 2 m worse for it. Turns that are wrong by 0.3 to 1 rad have 7.8 and more in three worlds."""
SHOWN_TURN = math.radians(1.0)
"""[rad] Error of a turn restated by ranges."""


class OdometryWatch:
    """Learns how much views change on the way, and says when one changes far more, or for long not as wheels say.

    seen: what the last step was by views, ranges or what is usual, where the odometry's can't be true and this explains
    what is seen; else None; said: what was found of such a step, in plain words, "" for nothing; turned: whether the
    view turned in it as no wheel did.
    """

    def __init__(self) -> None:
        self._previous: Panorama | None = None
        self._earlier: tuple[Panorama, Pose2] | None = None  # the view before that, and the step from it as read
        self._usual = UsualChange()
        self._quickest = 0.0  # the quickest turn so far [rad/s]
        self._dead = self._spinning = 0
        self._owed = 0.0, 0.0  # way [m] and turn [rad] while the camera repeated its frame: the next view shows them
        self._leaps = Leaps(MEMORY)
        self._scans = ScanWatch()
        self.seen: Restated | None = None
        self.said = ""
        self.turned = False

    @property
    def doubted(self) -> bool:
        """Whether wheels and views contradict one another now."""
        # where ranges show the way, they have had their say first
        patience = PATIENCE + STEPS if self._scans.sees else PATIENCE
        return not (self._scans.untrue or self._scans.pending) and max(self._dead, self._spinning) >= patience

    def restate(self, previous: Panorama | None) -> None:
        """Take the last view for another one: its camera leant otherwise than was known."""
        self._previous = previous
        self._leaps.begin()

    def judge(self, panorama: Panorama, motion: MotionReading, calibration: Calibration) -> str:
        """Return why the robot isn't where odometry has it, or "": it was carried away, or wheels failed until now."""
        previous, self._previous = self._previous, panorama
        self.seen, self.said, self.turned = None, "", False
        if previous is None:
            self._scans.begin(panorama)
            return ""
        read = _corrected(motion, calibration)
        earlier, self._earlier = self._earlier, (previous, advance(Pose2(), read))
        owed_way, owed_turn = self._owed
        change, whole = view_change(panorama, previous, float(motion.turn) + owed_turn)
        driven = abs(motion.forward) + abs(motion.left)
        way = driven + TURN_WAY * abs(motion.turn)
        unturned = view_change(panorama, previous, 0.0)
        repeated = unturned[0] < UNMOVED * self._usual.change and self._may_turn(motion)
        self._owed = (owed_way + way, owed_turn + float(motion.turn)) if repeated else (0.0, 0.0)
        if repeated:  # it shows nothing of the step, so that it announces nothing either
            change, whole = unturned
        leapt = self._leaps.judge(driven, motion.dt, panorama, previous, self._usual.change)
        self._usual.note(change, whole)
        turned = self._usual.exceeded(change, way + owed_way) and not (leapt or self._usual.announced or repeated)
        structure = structure_change(panorama, previous, 0.0 if repeated else float(motion.turn) + owed_turn)
        if turned and self._is_light(structure, earlier, previous, panorama, read):
            turned = False
            self.said = f"the light changed: the view by {change:.2f}, what stands there by {structure:.2f}"
        turn = seen_turn(panorama, previous) - owed_turn if leapt or turned or self._scans.untrue else 0.0
        if turned and self._usual.unusual(view_change(panorama, previous, turn + owed_turn)[0], way + owed_way):
            self._scans.begin(panorama)
            self._leaps.begin()
            return f"carried away: the view changed by {change:.2f}, usual over a step is {self._usual.change:.2f}"
        doubted, self.turned = self.doubted, turned
        dead, spinning = self._contradicted(change, way, driven)
        moves = change > MOVING * self._usual.change > 0.0
        misread = turned or (
            leapt and self._misread(panorama, previous, float(motion.turn) + owed_turn, turn + owed_turn)
        )
        self._restate(panorama, read, turn, leapt, turned, misread, moves)
        if self._scans.untrue or self._scans.pending or leapt or turned:
            return ""
        ended = ""
        if doubted and not self.doubted:
            ended = f"the odometry stood still for {dead} steps" if dead else f"the wheels spun for {spinning} steps"
        if not self.said:
            self._usual.happened(change, way + owed_way)
        if way > self._usual.still and not self._spinning and change < TIMES * max(self._usual.change, LEAST):
            self._usual.learn(change, structure, way + owed_way)
            self._leaps.learn(driven, motion.dt)
            self._quickest = max(self._quickest, abs(float(motion.turn)) / max(float(motion.dt), SHORTEST))
        return ended

    def _may_turn(self, motion: MotionReading) -> bool:
        """Return whether the robot may have turned as the odometry reads."""
        return abs(float(motion.turn)) <= QUICKER * max(self._quickest, BRISK) * max(float(motion.dt), SHORTEST)

    def _misread(self, now: Panorama, previous: Panorama, read: float, seen: float) -> bool:
        """Return whether views contradict the turn that is read [rad], the one between them being `seen`."""
        return view_change(now, previous, read)[0] > LESS_ALIKE * view_change(now, previous, seen)[0]

    def _restate(
        self, panorama: Panorama, read: Motion, turn: float, leapt: bool, turned: bool, misread: bool, moves: bool
    ) -> None:
        """Take the step as what is seen has it, where the odometry's can't be true; turn: by the views [rad], asked
        where one of these holds; misread: they contradict the turn, too."""
        usual = self._leaps.usual
        by_usual = leapt or self._scans.untrue
        if by_usual or turned:
            ways = SEEN_WAY if by_usual else None
            turns = SEEN_TURN if misread or self._scans.turn_untrue else None
            forward, left = (usual, 0.0) if by_usual else (read.forward, read.left)
            self.seen = Restated(forward, left, turn, ways, turns)
        if leapt and not self._leaps.before:
            self.said = f"the odometry leapt by {abs(read.forward):.1f} m in a step; the usual {usual:.2f} m are taken"
        elif turned:
            self.said = f"turned by {math.degrees(turn):.0f} degrees, which the odometry doesn't count"
        believed = read if self.seen is None else _stated(read, self.seen)
        shown = self._scans.step(
            panorama, advance(Pose2(), read), advance(Pose2(), believed), usual, self._dead > 0, moves
        )
        self.said = self.said or self._scans.said
        if shown is not None:
            c, s = math.cos(shown.heading / 2), math.sin(shown.heading / 2)
            forward, left = c * shown.x + s * shown.y, c * shown.y - s * shown.x
            self.seen = Restated(forward, left, shown.heading, SEEN_WAY, SHOWN_TURN)

    def _is_light(
        self, structure: float, earlier: tuple[Panorama, Pose2] | None, previous: Panorama, now: Panorama, read: Motion
    ) -> bool:
        """Return whether a change of the view is one of the light alone; structure: the change without light."""
        if structure < min(LIT * self._usual.structure, LIT_MOST):
            return True
        if structure >= LIT_STILL:
            return False
        share = 0.0 if earlier is None else LIT_SHARE * share_of(earlier[0], previous, earlier[1])
        return ranges_confirm(previous, now, advance(Pose2(), read), share)

    def _contradicted(self, change: float, way: float, driven: float) -> tuple[int, int]:
        """Count steps in which wheels stand and the view moves, or the other way round; return the counts so far.

        driven: the way without turning [m], which leaves the view as it was but for its direction.
        """
        dead, spinning = self._dead, self._spinning
        if not self._usual.known:
            return 0, 0
        usual, still = self._usual.change, self._usual.still
        slow = min(driven / self._usual.way, 1.0)
        self._dead = self._dead + 1 if way <= still and MOVING * usual < change else 0
        stands = change < UNMOVED * usual * slow and not self._scans.company.present
        self._spinning = self._spinning + 1 if driven > still and stands else 0
        return dead, spinning


def _corrected(motion: MotionReading, calibration: Calibration) -> Motion:
    way = float(motion.forward), float(motion.left), float(motion.turn)
    return calibration.correct(Motion(*way, np.asarray(motion.covariance, np.float64), float(motion.dt)))


def _stated(read: Motion, seen: Restated) -> Motion:
    forward, left = (read.forward, read.left) if seen.ways is None else (seen.forward, seen.left)
    turn = read.turn if seen.turns is None else seen.turn
    return Motion(forward, left, turn, read.covariance, read.dt)
