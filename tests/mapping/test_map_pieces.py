"""Small pieces of the map and its solver, each where a mistake in it would show."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from maps import square

from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.mapping.mapfile import from_bytes, to_bytes
from topomap.mapping.optimizer.pose_network import _missed
from topomap.mapping.optimizer.residuals import _axis
from topomap.mapping.places.recognition import Recognition, RecognitionSettings
from topomap.mapping.sequential import SequentialConstraints
from topomap.mapping.uncertainty.network_search import _drop, _left, _purged, _push, _signposts
from topomap.vision.homing.epipolar import ENOUGH


def test_what_is_left_is_the_most_that_a_landmark_tells() -> None:
    landmarks = np.array([[1.0, 5.0, 2.0], [4.0, 3.0, 2.0]])
    assert _left(landmarks, np.array([0, 1, 2]), 0, 1) == 3.0
    assert _left(landmarks, np.array([1, 2]), 1, 0) == 2.0


def test_the_landmarks_that_tell_most_are_the_signposts() -> None:
    chosen = np.empty(2, np.int64)
    _signposts(np.array([[1.0, 5.0, 2.0], [4.0, 0.0, 2.0]]), 0, 1, chosen)
    assert chosen.tolist() == [1, 0]


def test_a_heap_gives_the_nearest_first_and_loses_only_what_a_shorter_way_replaced() -> None:
    rng = np.random.default_rng(3)
    gone, node = rng.permutation(40.0 * np.arange(1, 41)).reshape(2, 20).T, np.arange(20)
    queue, queued = np.empty((40, 2)), np.empty(40, np.int64)
    for size, (way, which) in enumerate(zip(gone.ravel().tolist(), np.repeat(node, 2).tolist(), strict=True)):
        _push(queue, queued, size, way + which, -way, which)  # two ways to each node
    left = _purged(queue, queued, gone.min(axis=1))
    assert left == 20
    popped = []
    for size in range(left, 0, -1):
        popped.append((queue[0, 0], -queue[0, 1], queued[0]))
        _drop(queue, queued, size)
    shortest = gone.min(axis=1)
    assert popped == sorted(zip((shortest + node).tolist(), shortest.tolist(), node.tolist(), strict=True))


@pytest.mark.parametrize("blind", [False, True])
def test_what_a_link_misses_changes_with_both_poses_as_its_derivatives_say(blind: bool) -> None:
    start, end, claimed = np.array([0.4, -1.1, 0.7]), np.array([2.0, 0.3, 1.5]), np.array([1.2, 0.4, 0.3])
    missed, by_i, by_j = np.empty(3), np.full((3, 3), np.nan), np.full((3, 3), np.nan)
    _missed(0, 1, claimed, blind, np.array([start, end]), missed, by_i, by_j)
    unused, step = np.empty((3, 3)), 1e-6
    for k in range(3):
        moved, turn = np.empty(3), np.eye(3)[k] * step
        for poses, slope in (((start + turn, end), by_i[:, k]), ((start, end + turn), by_j[:, k])):
            _missed(0, 1, claimed, blind, np.array(poses), moved, unused, unused.copy())
            told = (moved - missed) / step
            free = 3 if not blind else 2  # a blind link's heading is tied whatever it is
            assert told[:free] == pytest.approx(slope[:free], abs=1e-5)
    assert not blind or (by_i[2].tolist(), by_j[2].tolist(), missed[2]) == ([0, 0, -1], [0, 0, 1], 0)


def test_no_headings_lie_along_no_axis() -> None:
    assert _axis(np.zeros(0), np.zeros(0)) == 0.0


def test_headings_modulo_a_right_angle_tell_the_axis_and_one_across_does_not_turn_it() -> None:
    along = np.array([0.2, 0.2 + np.pi / 2, 0.2 - np.pi, 0.21, 0.19])
    assert _axis(np.append(along, 0.9), np.full(6, 0.02)) == pytest.approx(0.2, abs=1e-3)


def test_a_map_of_one_node_is_kept_and_read() -> None:
    one = square()
    empty = type(one)()
    empty.add(one.nodes[0], None)
    again = from_bytes(to_bytes(empty))
    assert len(again.nodes) == 1
    assert again.chain == [0]


def test_the_first_snapshots_alone_tell_how_fast_views_change() -> None:
    """Nothing is seen between them, so that only what each is compared with when it is stored can tell."""
    recognition, rig = Recognition(RecognitionSettings()), Rig()
    rng = np.random.default_rng(3)
    for k in range(12):
        image = np.kron(rng.uniform(40, 210, (10, 24, 1)), np.ones((rig.height // 10, rig.width // 24, 3)))
        recognition.add(k, float(k), Panorama(image.astype(np.uint8), None, rig))
    assert recognition.catchment.length > 0.0


@pytest.mark.parametrize(("points", "rotation", "believed"), [
    (ENOUGH, 0.1, True), (ENOUGH - 1, 0.1, False), (ENOUGH, 2.0, False),
])  # fmt: skip
def test_a_turn_matched_by_few_points_or_far_from_what_was_read_is_none(
    points: int, rotation: float, believed: bool
) -> None:
    topo = square()
    blunt = SimpleNamespace(align=lambda *_: SimpleNamespace(rotation=0.0, sharp=False))
    constraints = SequentialConstraints(blunt, topo)
    said = SimpleNamespace(rotation=rotation, points=points)
    constraints._second = SimpleNamespace(
        window=None, method=SimpleNamespace(describe=lambda view: view, movement=lambda *_: said)
    )
    view = Panorama(np.full((Rig().height, Rig().width, 3), 90, np.uint8), None, Rig())
    constraints.compare(0, 1, SimpleNamespace(panorama=lambda _: view))
    turns = [turn.turn for turn in constraints.turns]
    assert (turns == pytest.approx([rotation])) if believed else not turns
    assert all(math.isfinite(turn) for turn in turns)
