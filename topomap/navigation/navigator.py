"""The navigator: one step of the whole stack."""

from __future__ import annotations

from topomap.core.panorama import Panorama
from topomap.core.records import Command, Phase, StepRecord
from topomap.core.robot import Reading
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser import Localiser
from topomap.navigation.manoeuvres.active_check import ActiveCheck
from topomap.navigation.manoeuvres.relocalise import LOST, Relocalise
from topomap.navigation.mission import Mission
from topomap.navigation.stopwatch import Stopwatch
from topomap.navigation.traveller import Traveller


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
    ) -> None:
        self.mapper = mapper
        self.localiser = localiser
        self._mission = mission
        self._traveller = traveller
        self._active = active
        self._relocalise = relocalise

    @property
    def over(self) -> bool:
        """Whether the mission has ended."""
        return self._mission.over

    @property
    def phase(self) -> Phase:
        """What the robot is doing, or how the mission ended."""
        return self._mission.phase

    def step(self, reading: Reading) -> tuple[Command, StepRecord]:
        """Take one reading through all stages; return the command and the record of the step."""
        watch = Stopwatch()
        panorama = Panorama.from_reading(reading)
        watch.lap("panorama")
        change = self.mapper.update(reading, panorama)
        watch.lap("map")
        where = self.localiser.update(panorama, self.mapper, change, reading.driven)
        goal = self._mission.goal(reading.driven, self.mapper.map)
        watch.lap("localise")
        self.mapper.lost = where.lost > LOST
        checked = self._relocalise.step(panorama, reading.contact, where, goal, self.mapper)
        if checked is None and goal.phase is Phase.TRAVEL:
            checked = self._active.step(panorama, reading.contact, self.mapper)
        if checked is not None:
            self._traveller.pause()
        turn = self.mapper.track.turn
        command, travel = checked or self._traveller.step(panorama, turn, where, goal, self.mapper)
        self._mission.report(travel)
        watch.lap("travel")
        return command, StepRecord(
            reading.stamp_ns, self.mapper.track.raw, change, where, goal, travel, command, watch.laps
        )
