"""Travelling: along a planned course, steered by view and belief, until the goal is recognised or given up."""

from __future__ import annotations

from pydantic import BaseModel, Field, model_validator

from topomap.core.errors import TopomapError
from topomap.core.records import Command, Goal, Phase, Travel, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation.homeward import Homeward
from topomap.navigation.journey import Journey
from topomap.navigation.manoeuvres.back_off import BackOff
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.progress import PATIENCE
from topomap.navigation.recovery import Remedy, Trouble
from topomap.navigation.remedies import Remedies
from topomap.navigation.senses import Now, Senses
from topomap.navigation.steering import LOST
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.choice import CompassChoice, HomingChoice, found
from topomap.vision.registry import aligned_homing

SOUGHT = 80
"""Steps within which the goal must be recognised once it is near: four times what the last 0.7 m take."""
OFF_COURSE, OFF_STEPS = 1.5, 4
"""[m] So far off its course, for so many steps, the robot needs another one."""
LOST_STEPS = 8
"""Steps of being lost before something is done about it: one odd view says little."""
UNSEEN = 2
"""Milestones in a row that weren't seen after which getting no further means being lost, not blocked."""
STAND_STEPS = 40
"""Steps of standing without senses before the journey is given up: 10 s."""
BEYOND = 0.15
"""[m] Where something stands in the way, it stands so far ahead of the body: the pilot keeps 6 cm free."""


class TravelSettings(BaseModel, frozen=True, extra="forbid"):
    """How a journey is made."""

    homing: HomingChoice = Field("min-warping", description="the method that homes, by its name in `topomap methods`")
    aligner: CompassChoice = Field(
        "own", description="the aligner it is given its rotation by; own: the method's own, or min-warping"
    )
    pilot: PilotSettings = PilotSettings()

    @model_validator(mode="after")
    def _fit(self) -> TravelSettings:
        """Refuse an aligner for what aligns by itself."""
        found(aligned_homing, self.homing, self.aligner)
        return self


class Traveller:
    """Plans, follows the course past its milestones, notices arrival, recovers, gives up; speed: its limit [m/s]."""

    def __init__(self, settings: TravelSettings, homing: AlignedHoming) -> None:
        s = settings.pilot
        self._pilot = Pilot(s)
        self._homing = homing
        self._radius = s.body_radius
        self.speed = s.speed
        self._homeward = Homeward(homing, self._pilot, s.speed)
        self._remedies = Remedies(self._pilot, s.turn_rate)
        self._back_off = BackOff(s.body_radius)
        self._journey: Journey | None = None
        self._forward = False
        self._checked = False

    def step(self, senses: Senses, where: Where, goal: Goal, mapper: Mapper) -> tuple[Command, Travel]:
        """Return the command of this step and what was done."""
        if goal.node is None:
            self._check(senses)
            self._journey = None
            return Command(), Travel(goal.phase)
        now = Now(senses, where, mapper, self._back_off.ranges(senses.ranges, mapper.track.raw))
        try:
            command, travel = self._travel(self._journey_to(goal.node, now), now)
        except TopomapError as error:
            command, travel = Command(), Travel(Phase.FAILED, note=str(error))
        self._forward = command.forward > 0.0
        if travel.phase is not Phase.TRAVEL:
            self._journey = None
        return command, travel

    def pause(self) -> None:
        """Look anew when travelling goes on: something else has the wheels."""
        if self._journey is not None:
            self._journey.sight = None

    def _check(self, senses: Senses) -> None:
        """Say at the first view, not after a whole lesson, that the robot lacks what the method needs."""
        if not self._checked and self._homing.method is not None:
            self._homing.method.needs.check(senses.panorama)
        self._checked = True

    def _journey_to(self, goal: int, now: Now) -> Journey:
        """Return the journey under way, or a new one. Raises TopomapError where there is no way."""
        if self._journey is None or self._journey.goal != goal:
            self._journey = Journey.begin(goal, now)
        return self._journey

    def _travel(self, j: Journey, now: Now) -> tuple[Command, Travel]:
        """Stand where nothing can be sensed; else go on with what is being tried, or along the course."""
        j.steps += 1
        if now.senses.health.stop:
            return self._stand(j, now)
        j.stood = 0
        if j.over_budget(self._homeward.patience):
            return self._fail(j, f"no arrival after {j.steps} steps and {j.plans} plans")
        back = self._back_off.step(now.senses.contact, now.mapper.track.raw, now.mapper.track.travel, self._forward)
        if back is not None:
            return back, self._told(j, "contact: backing off" if now.senses.contact else "")
        self._follow(j, now)
        trouble = self._trouble(j, now)
        if trouble is not None:
            return self._help(j, trouble, now)
        if j.remedy is not None:
            command = self._remedies.step(j, now)
            if command is not None:
                return command, self._told(j)
            j.remedy = None
            j.progress.trouble()
        return self._homeward.step(j, now)

    def _follow(self, j: Journey, now: Now) -> None:
        """Keep up with the belief; one that has been elsewhere for a while needs another course."""
        if now.where.lost >= LOST:
            j.progress.idle += 1
            return
        off = j.course.follow(now.where.pose)
        j.step_back()
        j.astray_for = j.astray_for + 1 if off > OFF_COURSE else 0
        if j.astray_for > OFF_STEPS:
            j.astray_for = 0
            j.plan(now)
        if j.progress.update(j.course.left + off):
            j.recovery.made_progress()

    def _trouble(self, j: Journey, now: Now) -> Trouble | None:
        """Return what keeps the journey from getting on, unless something is being tried already."""
        if j.remedy is not None:
            return None
        j.lost_for = j.lost_for + 1 if now.where.lost >= LOST else 0
        if j.lost_for > LOST_STEPS:
            return Trouble.LOST
        if j.sought > SOUGHT * self._homeward.patience:
            return Trouble.UNCERTAIN
        stuck = j.progress.idle > PATIENCE * self._homeward.patience
        if not stuck or j.sought:
            return None
        return Trouble.LOST if j.unseen >= UNSEEN else Trouble.BLOCKED

    def _help(self, j: Journey, trouble: Trouble, now: Now) -> tuple[Command, Travel]:
        """Begin the next remedy."""
        remedy = j.recovery.next(trouble)
        j.lost_for, j.sought, j.sight = 0, 0, None
        j.progress.trouble()
        if remedy is Remedy.GIVE_UP:
            return self._fail(j, f"gave up on the way to node {j.goal}: {trouble}")
        note = f"{trouble}: {remedy}"
        if remedy is Remedy.REPLAN:
            note = self._replan(j, now) or note
        else:
            self._remedies.begin(j, remedy)
        return Command(), self._told(j, note)

    def _replan(self, j: Journey, now: Now) -> str:
        """Plan round the place ahead; without another way the place counts as open again. Return why, or ""."""
        j.shut_ahead(now.mapper.map, self._radius + BEYOND, now.senses.stamp_ns)
        try:
            j.plan(now)
        except TopomapError as error:
            j.shut = ()
            return f"{Trouble.BLOCKED}: {error}"
        return ""

    def _stand(self, j: Journey, now: Now) -> tuple[Command, Travel]:
        """Stop the wheels for as long as there is hope."""
        j.stood += 1
        why = now.senses.health.stop
        return self._fail(j, why) if j.stood > STAND_STEPS else (Command(), self._told(j, why if j.stood == 1 else ""))

    @staticmethod
    def _fail(j: Journey, why: str) -> tuple[Command, Travel]:
        return Command(), Travel(Phase.FAILED, j.sight.node if j.sight else None, note=why)

    @staticmethod
    def _told(j: Journey, note: str = "") -> Travel:
        return Travel(Phase.TRAVEL, j.sight.node if j.sight else None, legs_left=j.legs_left, note=note)
