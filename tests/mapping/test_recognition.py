"""What is proposed adapts to how different places look here."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.mapping.places.recognition import Recognition, RecognitionSettings


def views(contrast: float, count: int, seed: int = 0) -> list[Panorama]:
    """Panoramas that share a pattern and differ by their own, of which `contrast` says how much."""
    rng = np.random.default_rng(seed)
    rig = Rig()
    shape = (10, 24, 1)
    shared, found = rng.uniform(60, 190, shape), []
    for _ in range(count):
        small = (1 - contrast) * shared + contrast * rng.uniform(60, 190, shape)
        image = np.kron(small, np.ones((rig.height // 10, rig.width // 24, 3)))
        found.append(Panorama(image.astype(np.uint8), None, rig))
    return found


def limit(contrast: float) -> float:
    recognition = Recognition(RecognitionSettings())
    for k, view in enumerate(views(contrast, 20)):
        recognition.update(k, float(k), view, np.zeros(0, np.int64))
        recognition.add(k, float(k), view)
    return recognition.limit


def test_the_limit_is_lower_where_all_places_look_alike() -> None:
    assert 0.05 < limit(0.2) < 0.6 * limit(0.9)


def test_nothing_is_proposed_before_other_places_were_seen() -> None:
    recognition = Recognition(RecognitionSettings())
    assert recognition.limit == 0.0
    view = views(0.5, 1)[0]
    recognition.add(0, 0.0, view)
    recognition.update(1, 3.0, view, np.zeros(0, np.int64))
    assert recognition.limit == 0.0


@pytest.mark.parametrize(("share", "proposed"), [(0.7, False), (1.4, True)])
def test_the_threshold_is_a_share_of_the_usual_difference(
    share: float, proposed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("topomap.mapping.places.recognition.THRESHOLD", share)
    recognition = Recognition(RecognitionSettings())
    several = views(0.9, 26)
    for k, view in enumerate(several[:20]):
        recognition.update(k, float(k), view, np.zeros(0, np.int64))
        recognition.add(k, float(k), view)
    found = []
    for k, view in enumerate(several[20:]):
        recognition.update(20 + k, 20.0 + k, view, np.arange(10))
        found.append(recognition.proposal())
    assert any(proposal is not None for proposal in found) == proposed


def test_a_pass_is_proposed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every third view is a place's own, a minimum each, but what follows within 0.3 m sees the same places."""
    every = proposed(0.0, monkeypatch)
    assert np.diff(every).max() < 0.3
    some = proposed(0.3, monkeypatch)
    assert 2 <= len(some) < len(every)
    assert np.diff(some).min() >= 0.3 - 1e-9


def proposed(pause: float, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The ways [m] at which places are proposed on a drive of 0.06 m a step."""
    if pause != 0.3:
        monkeypatch.setattr("topomap.mapping.places.recognition.PAUSE", pause)
    else:
        monkeypatch.undo()
    recognition = Recognition(RecognitionSettings())
    several = views(0.9, 40)
    for k, one in enumerate(several[:30]):
        recognition.update(k, float(k), one, np.zeros(0, np.int64))
        recognition.add(k, float(k), one)
    found = []
    for k in range(30):
        one = several[k // 3] if k % 3 == 1 else several[30 + k % 10]
        recognition.update(100 + k, 60.0 + 0.06 * k, one, np.arange(10))
        proposal = recognition.proposal()
        if proposal is not None:
            found.append(proposal.moment.travel)
    return found


@pytest.mark.parametrize("steps_left", [0, 1, 2])
def test_the_last_moments_of_a_drive_are_examined_when_it_ends(
    steps_left: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("topomap.mapping.places.recognition.THRESHOLD", 0.5)
    recognition = Recognition(RecognitionSettings())
    several = views(0.9, 40)
    for k, one in enumerate(several[:30]):
        recognition.update(k, float(k), one, np.zeros(0, np.int64))
        recognition.add(k, float(k), one)
    for k, one in enumerate([*several[30:35], several[4], *several[35 : 35 + steps_left]]):
        recognition.update(100 + k, 60.0 + 0.04 * k, one, np.arange(10))
        assert recognition.proposal() is None
    proposal = recognition.proposal(ended=True)
    assert proposal is not None
    assert (proposal.moment.stamp_ns, proposal.places[0].node) == (105, 4)
    assert recognition.proposal(ended=True) is None


def test_a_pass_is_proposed_where_the_place_is_most_alike() -> None:
    """The view comes nearer to a place's own and leaves it again, all the while more alike than places usually are."""
    recognition, several = Recognition(RecognitionSettings()), views(0.9, 21)
    imminent = []
    for k, view in enumerate(several[:20]):
        recognition.update(k, float(k), view, np.zeros(0, np.int64))
        recognition.add(k, float(k), view)
    own, other, found = several[5].image.astype(float), several[20].image.astype(float), []
    for step in range(-9, 10):
        share = 1.0 - 0.06 * abs(step)
        seen = Panorama((share * own + (1.0 - share) * other).astype(np.uint8), None, several[0].rig)
        recognition.update(100 + step, 25.0 + 0.12 * step, seen, np.arange(10))
        proposal = recognition.proposal()
        found += [] if proposal is None else [(proposal.moment.stamp_ns, proposal.places[0].node)]
        near = None if found else recognition.imminent()
        imminent += [] if near is None else [near.stamp_ns]
    assert found == [(100, 5)]
    assert imminent == [100], "one step before, and no moment on the way there"


def test_a_rival_was_left_about_as_long_ago_as_the_place_it_is_held_against() -> None:
    """The second lap looks at its own last views, which lie as far beside the way, before the first lap's."""
    first, beside = views(0.9, 40), views(0.9, 1, seed=1)[0]
    recognition = Recognition(RecognitionSettings())
    for k, view in enumerate([*first, beside, *views(0.9, 9, seed=2)]):
        recognition.update(k, float(k), view, np.zeros(0, np.int64))
        recognition.add(k, float(k), view)
        recognition.proposal()
    seen = Panorama(cv2.addWeighted(beside.image, 0.7, first[10].image, 0.3, 0.0), None, beside.rig)
    proposals = []
    for k, view in enumerate([seen, *views(0.9, 4, seed=3)]):
        place = recognition.update(50 + k, 50.0 + k, view, np.arange(8, 13))
        proposals += [recognition.proposal()]
        if view is seen:
            assert place is not None
            assert place.node == 40, "what is the most alike is said as it is"
    found = next(one for one in proposals if one is not None)
    assert found.places[0].node == 10
    assert max(rival.node for rival in found.rivals) <= 30
    assert max(found.older) <= 30
