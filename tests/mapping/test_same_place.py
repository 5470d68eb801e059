"""What is usual here decides how alike the same spot must look."""

from __future__ import annotations

import numpy as np

from topomap.core.geometry import Pose2
from topomap.mapping.closures.relative_pose import Offset
from topomap.mapping.closures.same_place import SamePlaceSettings, SamePlaceTest

UNMEASURED = Offset(Pose2(0.0, 0.0, 0.0), np.diag([0.35, 0.03, 0.05]) ** 2, 0.4)
MEASURED = Offset(Pose2(0.0, 0.0, 0.0), np.diag([0.04, 0.03, 0.02]) ** 2, 0.7)


def test_a_view_much_less_alike_than_usual_is_near_the_place_only() -> None:
    same_place = SamePlaceTest(SamePlaceSettings())
    assert not any(same_place.objection(0.6, UNMEASURED) for _ in range(9))  # nothing is usual yet
    assert not any(same_place.objection(0.2, UNMEASURED) for _ in range(30))
    assert "usually 0.20" in same_place.objection(0.6, UNMEASURED)
    assert same_place.objection(0.39, UNMEASURED) == ""
    assert same_place.objection(0.6, MEASURED) == ""


def test_what_is_usual_follows_the_light() -> None:
    same_place = SamePlaceTest(SamePlaceSettings())
    for _ in range(30):
        same_place.objection(0.2, UNMEASURED)
    dimmed = [bool(same_place.objection(0.6, UNMEASURED)) for _ in range(30)]
    assert dimmed[0]
    assert not any(dimmed[16:])


def test_a_place_measured_a_metre_off_is_another_one() -> None:
    same_place = SamePlaceTest(SamePlaceSettings())
    away = Offset(Pose2(-0.5, 0.8, 1.5), MEASURED.covariance, 0.5)
    assert "0.94 m apart" in same_place.objection(0.2, away)
    assert same_place.objection(0.2, Offset(Pose2(0.0, 0.7, 1.5), MEASURED.covariance, 0.5)) == ""
