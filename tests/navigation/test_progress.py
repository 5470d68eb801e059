"""Whether a journey gets on, and when a trouble is over."""

from __future__ import annotations

from topomap.navigation.progress import RECOVERED, STRETCH, Progress
from topomap.navigation.recovery import LADDER, Recovery, Remedy, Trouble


def test_only_a_gain_of_some_length_counts() -> None:
    progress = Progress()
    for left in (10.0, 9.9, 9.8, 10.0 - 1.1 * STRETCH):
        progress.update(left)
    assert progress.idle == 0
    for _ in range(7):
        progress.update(9.7)
    assert progress.idle == 7


def test_a_trouble_is_over_beyond_its_place_only() -> None:
    progress = Progress()
    progress.update(10.0)
    progress.trouble()
    assert not progress.update(12.0)  # gone back
    assert not progress.update(10.0 - 0.9 * RECOVERED)
    assert progress.update(10.0 - 1.1 * RECOVERED)
    assert not progress.update(1.0)


def test_on_a_new_course_what_is_tried_begins_anew_after_some_progress() -> None:
    progress = Progress()
    progress.update(2.0)
    progress.trouble()
    progress.renew()
    assert not progress.update(20.0)
    assert not progress.update(20.0 - 0.9 * RECOVERED)
    assert progress.update(20.0 - 1.1 * RECOVERED)


def test_remedies_come_in_their_order_and_giving_up_stays_the_last() -> None:
    recovery = Recovery()
    for trouble, ladder in LADDER.items():
        assert [recovery.next(trouble) for _ in range(len(ladder) + 2)] == [*ladder, Remedy.GIVE_UP, Remedy.GIVE_UP]
    recovery.made_progress()
    assert recovery.next(Trouble.BLOCKED) is Remedy.LOOK
