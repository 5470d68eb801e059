"""One drive's likenesses, each judged by the truth."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from topomap.core.evidence import FALSE_DISTANCE, FALSE_ROTATION
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.robot import Reading
from topomap.mapping.look_survey import LookSurvey
from topomap.vision.contracts import Aligner


@dataclass(frozen=True, slots=True)
class Row:
    """A likeness: world and seed; costs of the winner, of the best rival and usual elsewhere; what looks says (a log
    likelihood ratio); distance [m] and rotation [rad] by which it misses, and whether it is true.
    """

    world: str
    seed: int
    cost: float
    rival: float
    usual: float
    looks: float
    distance: float
    rotation: float
    true: bool


def survey(world: str, seed: int, drive: Iterable[tuple[Reading, Pose2]], aligner: Aligner) -> list[Row]:
    """Return the likenesses of a drive's readings with their true poses; the poses stand for a map that is right."""
    found, poses, looking = [], dict[int, Pose2](), LookSurvey(aligner)
    for reading, pose in drive:
        poses[reading.stamp_ns] = pose
        view = Panorama.from_reading(reading)
        like = looking.update(reading.stamp_ns, reading.motion.forward, view, pose.x, pose.y)
        if like is not None:
            query, match = poses[like.query_ns], poses[like.match_ns]
            away = math.hypot(query.x - match.x, query.y - match.y)
            turned = wrap(like.rotation - (query.heading - match.heading))
            true = away <= FALSE_DISTANCE and abs(turned) <= FALSE_ROTATION
            found.append(Row(world, seed, like.cost, like.rival, like.usual, like.looks, away, turned, true))
    return found
