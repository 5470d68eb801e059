"""Min-warping's kernels against the formulas written out, and its cost's scale."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import Room

from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, warping_view
from topomap.vision.matching.warping import best, movements, warp
from topomap.vision.matching.warping_kernels import scale_planes, warping_search, whole_search


def test_planes_are_the_normalised_differences() -> None:
    rng = np.random.default_rng(0)
    a, b = (rng.normal(size=(2, 2, 5, 6)).astype(np.float32) for _ in range(2))
    sums = np.abs(a).sum(axis=2), np.abs(b).sum(axis=2)
    planes = scale_planes(a, b, *sums, 0.5)
    assert planes.shape == (6, 6, 12)
    for plane, (k, m) in enumerate([(0, 1), (0, 0), (1, 0)]):
        for phase in (0, 1):
            for i, j in [(0, 0), (2, 5), (4, 1)]:
                top = np.abs(a[k, 0, :, i] - b[m, phase, :, j]).sum()
                wanted = top / (sums[0][k, 0, i] + sums[1][m, phase, j] + 0.5)
                assert planes[2 * plane + phase, i, (-j) % 6] == pytest.approx(wanted, rel=1e-5)
                assert planes[2 * plane + phase, i, (-j) % 6 + 6] == pytest.approx(wanted, rel=1e-5)


def test_movements_obey_the_law_of_sines() -> None:
    n, phases, levels, step = 72, 2, 4, 1.08
    shifts, planes, counts = movements(n, phases, levels, step)
    for x in (1, 9, 18, 30, 60, 71):
        for t in range(counts[x]):
            plane, phase = divmod(int(planes[x, t]), phases)
            angle, y = wrap(x * TAU / n), (shifts[x, t] + phase / phases) * TAU / n
            assert angle * y >= 0, "landmarks move away from the direction of travel"
            sigma = math.sin(angle + y) / math.sin(angle)
            assert abs(math.log(sigma) / math.log(step) - (plane - levels)) <= 0.5 + 1e-9


def test_search_is_the_sum_of_least_differences() -> None:
    rng = np.random.default_rng(1)
    n, phases, levels = 12, 2, 2
    planes = rng.random(((2 * levels + 1) * phases, n, n)).astype(np.float32)
    turned = np.concatenate([planes, planes], axis=2)
    table = movements(n, phases, levels, 1.2)
    cost = warping_search(turned, *table, np.arange(n), -3, 5)
    for alpha, p in [(0, 0), (5, 2), (11, 4)]:
        total = 0.0
        for i in range(n):
            x = (i - alpha) % n
            choices = zip(table[0][x, : table[2][x]], table[1][x, : table[2][x]], strict=True)
            total += min(planes[s, i, (-(i + y - (p - 3))) % n] for y, s in choices)
        assert cost[alpha, p] == pytest.approx(total / n, rel=1e-5)
    for first, width in ((-3, 5), (0, n), (40, 1)):
        one_by_one = warping_search(turned, *table, np.arange(n), first, width)
        assert np.array_equal(whole_search(turned, *table, first, width), one_by_one), "to the bit"


def test_a_window_finds_what_the_whole_search_finds() -> None:
    room = Room()
    goal, current = (warping_view(room.view(*pose), WARPING) for pose in ((3, 3, 0), (3.5, 2.6, 0.8)))
    whole, part = best(warp(current, goal)), best(warp(current, goal, 0.7, math.radians(30)))
    assert part.rotation == whole.rotation
    assert part.home == whole.home
    assert part.residual == pytest.approx(whole.residual, rel=0.02)
    outside = best(warp(current, goal, 2.5, math.radians(30)))
    assert abs(wrap(outside.rotation - 2.5)) <= math.radians(36)
    assert outside.residual > whole.residual + 0.1


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_residual_tells_the_place_from_another(seed: int) -> None:
    room, other = Room(seed), Room(seed + 50)
    goal = warping_view(room.view(3.7, 2.8, 0.4), WARPING)
    near = [best(warp(warping_view(room.view(3.7 + d, 2.8 - d, 2.0), WARPING), goal)) for d in (0.1, 0.3, 0.6)]
    far = [best(warp(warping_view(other.view(2.5 + d, 3.0, d), WARPING), goal)) for d in (0.0, 0.5, 1.0)]
    assert max(a.residual for a in near) < 0.8
    assert min(a.residual for a in far) > 0.88
    assert max(a.home.confidence for a in far if a.home) < 0.1


@pytest.mark.parametrize(("width", "height"), [(1, 5), (2, 2), (7, 1), (120, 25), (71, 30)])
def test_small_panoramas_dont_crash(width: int, height: int) -> None:
    rng = np.random.default_rng(width)
    rig = Rig(width, height, (height - 1) / 2, width / TAU)
    views = [Panorama(rng.integers(0, 256, (height, width, 3), dtype=np.uint8), rig=rig) for _ in range(2)]
    found = best(warp(*(warping_view(v, WarpingSpec()) for v in views)))
    assert math.isfinite(found.rotation)
    assert found.home is not None
    assert found.home.confidence <= 1.0


def mirrored(panorama: Panorama) -> Panorama:
    """What would be seen in a mirror: the bearing of every thing reversed."""
    return Panorama(panorama.image[:, -np.arange(panorama.rig.width)], None, panorama.rig)


def test_neither_side_is_favoured() -> None:
    """In a mirror the rotation is reversed: an average over straight drives has no side of its own."""
    room = Room(seed=4)
    for k in range(12):
        goal, current = room.view(1.5 + 0.3 * k, 3.0, 0.0), room.view(1.9 + 0.3 * k, 3.0, 0.02)
        seen = best(warp(warping_view(current, WARPING), warping_view(goal, WARPING), 0.0, 0.5)).rotation
        views = warping_view(mirrored(current), WARPING), warping_view(mirrored(goal), WARPING)
        assert best(warp(*views, 0.0, 0.5)).rotation == pytest.approx(-seen, abs=math.radians(0.02))
