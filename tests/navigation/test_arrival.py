"""When a milestone counts as reached."""

from __future__ import annotations

from topomap.navigation.arrival import Arrival


def steps_to_arrive(curve: list[float]) -> int | None:
    arrival = Arrival()
    return next((i for i, value in enumerate(curve) if arrival.update(value)), None)


def test_the_place_itself_is_reached_at_once() -> None:
    assert steps_to_arrive([0.9, 0.5, 0.1]) == 2


def test_a_passed_minimum_is_reached_two_steps_later() -> None:
    assert steps_to_arrive([0.9, 0.6, 0.4, 0.3, 0.34, 0.4, 0.5]) == 5


def test_one_noisy_step_is_no_passed_minimum() -> None:
    assert steps_to_arrive([0.9, 0.5, 0.56, 0.45, 0.4, 0.38]) is None


def test_a_high_minimum_is_another_place() -> None:
    assert steps_to_arrive([0.9, 0.7, 0.8, 0.9, 0.9, 0.9]) is None


def test_a_curve_that_rests_low_is_reached() -> None:
    assert steps_to_arrive([0.9, 0.5, 0.28] + [0.285] * 10) == 8
