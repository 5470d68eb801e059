"""The navigator: one step of the whole stack."""

from __future__ import annotations

from dataclasses import replace

from topomap.core.panorama import Panorama
from topomap.core.records import Command, Goal, Phase, StepRecord, Travel, Where
from topomap.core.robot import Reading
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser import Localiser
from topomap.navigation.localiser.belief import STRETCH
from topomap.navigation.localiser.localiser import STRETCHES
from topomap.navigation.manoeuvres.active_check import ActiveCheck
from topomap.navigation.manoeuvres.hall_course import HallCourse
from topomap.navigation.manoeuvres.relocalise import LOST, Relocalise
from topomap.navigation.mission import Mission
from topomap.navigation.odometry_check import OdometryCheck
from topomap.navigation.sense_check import SenseCheck
from topomap.navigation.senses import Senses
from topomap.navigation.stopwatch import Stopwatch
from topomap.navigation.traveller import Traveller

PROOF = STRETCHES * STRETCH
"""[m] Way that a robot that was carried or turned needs to prove where it is."""


class Navigator:
    """Maps, localises, decides and steers; knows no files, no bars, no plots and never the truth."""

    def __init__(
        self,
        mapper: Mapper,
        localiser: Localiser,
        mission: Mission,
        traveller: Traveller,
        active: ActiveCheck,
        relocalise: Relocalise,
        course: HallCourse | None = None,
    ) -> None:
        """course: drives instead of the traveller, where that is the mission."""
        self.mapper = mapper
        self.localiser = localiser
        self._mission = mission
        self._traveller = traveller
        self._active = active
        self._course = course
        self._relocalise = relocalise
        self._sense_check = SenseCheck()
        self._odometry = OdometryCheck(traveller.speed)
        self._command = Command()

    def take(self, mapper: Mapper) -> None:
        """Go on with the map of another mapper."""
        self.mapper = mapper

    @property
    def over(self) -> bool:
        """Whether the mission has ended."""
        return self._mission.over

    @property
    def phase(self) -> Phase:
        """What the robot is doing, or how the mission ended."""
        return self._mission.phase

    @property
    def failure(self) -> str:
        """Why the mission couldn't be, in one line, or ""."""
        return self._mission.failure

    def step(self, reading: Reading) -> tuple[Command, StepRecord]:
        """Take one reading through all stages; return the command and the record of the step."""
        watch = Stopwatch()
        panorama = self.mapper.seen(Panorama.from_reading(reading), float(reading.motion.turn))
        watch.lap("panorama")
        reading = self._odometry.checked(reading, panorama, self._command, self.mapper.map.calibration)
        change = self.mapper.update(reading, panorama)
        watch.lap("map")
        where = self.localiser.update(panorama, self.mapper, change, reading.driven)
        goal = self._mission.goal(reading.driven, self.mapper.map)
        watch.lap("localise")
        senses = self._sense_check.senses(reading, panorama, self.mapper.track.turn, change.place, self._odometry.amiss)
        self.mapper.lost = where.lost > LOST or self.localiser.searching
        if self._course is not None:
            command, travel = self._course.step(panorama, where.pose, self.mapper.track.raw)
        else:
            command, travel = self._travel(senses, where, goal)
        for event in (senses.health.event, self.mapper.restated_camera):
            travel = _with_event(travel, event)
        self._command = command
        self._sense_check.commanded(command)
        self._mission.report(travel, able=not senses.health.stop and where.lost <= LOST)
        watch.lap("travel")
        return command, StepRecord(
            reading.stamp_ns, self.mapper.track.raw, change, where, goal, travel, command, watch.laps
        )

    def _travel(self, senses: Senses, where: Where, goal: Goal) -> tuple[Command, Travel]:
        """Return what a manoeuvre does, or else the journey."""
        checked = self._manoeuvre(senses, where, goal)
        if checked is not None:
            self._traveller.pause()
        return checked or self._traveller.step(senses, where, goal, self.mapper)

    def _manoeuvre(self, senses: Senses, where: Where, goal: Goal) -> tuple[Command, Travel] | None:
        """Return what a manoeuvre that has the wheels does, None where the journey has them; none drives blind."""
        if senses.health.stop:
            return None
        seen = senses.trusted()
        searching = self.localiser.searching or (self.localiser.unproven and self._near(goal, where))
        found = self._relocalise.step(seen, senses.contact, where, goal, self.mapper, searching)
        if found is not None or goal.phase is not Phase.TRAVEL:
            return found
        return self._active.step(seen, senses.contact, self.mapper)

    def _near(self, goal: Goal, where: Where) -> bool:
        """Return whether the goal would be reached before it is proved that it is the goal."""
        return goal.node is not None and where.pose.distance(self.mapper.map.pose(goal.node)) < PROOF


def _with_event(travel: Travel, event: str) -> Travel:
    return replace(travel, note="; ".join(filter(None, (event, travel.note)))) if event else travel
