"""What the stages of seeing decide at their bounds: just enough to see, just too little, cameras that don't fit."""

from __future__ import annotations

import itertools
import math
from dataclasses import fields, is_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from kept import as_before
from scenes import Room
from stages import numbers

from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.core.rig import Rig
from topomap.vision import eye_level as eye_level_file
from topomap.vision.compass import ALIGNERS, rearrangement
from topomap.vision.compass.rearrangement import Rearrangement
from topomap.vision.eye_level import CLEAR, eye_level
from topomap.vision.homing import METHODS, auto
from topomap.vision.homing import POLICIES as METHODS_THAT_MOVE
from topomap.vision.homing.auto import Auto
from topomap.vision.homing.run_down import THRESHOLD
from topomap.vision.image.distances import fitted_coefficients
from topomap.vision.image.keypoints import KeypointSpec, Matches, _detected
from topomap.vision.image.landmarks import Landmarks, _nearest
from topomap.vision.image.pixel_selection import coloured
from topomap.vision.image.unwrap import MirrorRig, _rims, _sharpness, fit_mirror, unwrap, wrap_up
from topomap.vision.matching import scan_search
from topomap.vision.matching.image_flow import GreyView
from topomap.vision.matching.moment_potential import convergence_point
from topomap.vision.matching.scan_search import SearchSpec, places
from topomap.vision.matching.still import BACK, still
from topomap.vision.matching.two_view import EpipolarSpec, _grid, _peaks, movement
from topomap.vision.tilt import mount as mount_file
from topomap.vision.tilt import verticals
from topomap.vision.tilt.lean import UPRIGHT, Lean
from topomap.vision.tilt.mount import CLEAR as MOUNT_CLEAR
from topomap.vision.tilt.mount import ENOUGH, FAINT, FIRST, LEAST, SHARP, STILL, SURER, SWAYS, TOO_VAGUE, Mount
from topomap.vision.tilt.verticals import FEWEST, LeanReading, _fitted

SMALL = Rig(48, 20, 9.5, 48 / TAU, 0.5)


def around(bound: float) -> tuple[float, float, float]:
    """Just below, at, and just above."""
    return math.nextafter(bound, -math.inf), bound, math.nextafter(bound, math.inf)


def room(rig: Rig, x: float = 3.7, y: float = 2.8, heading: float = 0.4) -> Panorama:
    return Room().view(x, y, heading, rig)


@pytest.mark.parametrize("size", [(3, 2), (4, 3), (5, 4), (7, 5), (8, 5), (9, 6), (16, 9)])
def test_the_smallest_cameras_tell_as_much_as_before(size: tuple[int, int]) -> None:
    rig = Rig(*size, (size[1] - 1) / 2, size[0] / TAU, 0.5)
    here, there = room(rig), room(rig, 4.1, 3.1, 0.6)
    slow = ("warping-1d", "dtw-inhibited")
    found = {name: list(numbers(one.home(one.describe(here), one.describe(there))))
             for name, one in METHODS.items() if name not in slow}  # fmt: skip
    found |= {f"compass {name}": list(numbers(one.align(here, there))) for name, one in ALIGNERS.items()}
    as_before("smallest cameras", {f"{size[0]} {name}": one for name, one in found.items()}, part=True)


@pytest.mark.parametrize("scanned", [True, False])
def test_views_of_two_cameras_are_compared_by_none(scanned: bool) -> None:
    here, there = room(SMALL), room(replace(SMALL, width=52, focal=52 / TAU))
    if not scanned:
        here, there = replace(here, ranges=None), replace(there, ranges=None)
    said = {}
    for name, one in ALIGNERS.items():
        try:
            said[name] = [str(one.align(here, there))]
        except (ShapeError, DataError) as error:
            said[name] = [f"{type(error).__name__} {error}"]
    for name, method in METHODS.items():
        try:
            said[f"method {name}"] = [str(method.home(method.describe(here), method.describe(there)))]
        except (ShapeError, DataError) as error:
            said[f"method {name}"] = [f"{type(error).__name__} {error}"]
    as_before("two cameras", {f"{scanned} {name}": one for name, one in said.items()}, part=True)


def test_three_landmarks_are_rearranged_and_two_are_not(monkeypatch: pytest.MonkeyPatch) -> None:
    view, told = room(SMALL), []
    for here, there, metres in ((3, 3, 2.0), (2, 3, 2.0), (3, 2, 2.0), (3, 3, math.nan), (4, 4, 2.0)):
        marks = iter([Landmarks(np.arange(n) * 1.7, np.eye(n, 4), np.full(n, metres) + np.arange(n), SMALL)
                      for n in (here, there)])  # fmt: skip
        monkeypatch.setattr(rearrangement, "edges", lambda *_, marks=marks: next(marks))
        told += list(numbers(Rearrangement().align(view, view, 0.3)))
    as_before("rearranged", {"told": told})


def test_what_is_just_enough_to_see() -> None:
    picture = np.zeros((5, 8), np.uint8)
    picture[2, 3] = 1
    assert GreyView(picture, SMALL).tells
    for less in (picture[:4], picture[:, :7], np.zeros_like(picture)):
        assert not GreyView(less, SMALL).tells
    for size, found in (((16, 16), True), ((15, 40), False), ((40, 15), False)):
        noise = np.random.default_rng(1).integers(0, 255, size, np.uint8)
        looks = _detected(np.kron(noise, np.ones((1, 1), np.uint8)), KeypointSpec())[1]
        assert looks.shape[1] == 128
        assert found or not len(looks)
    for width in (2, 3):
        view = Panorama(np.zeros((2, width, 3), np.uint8), np.full(width, 2.0, np.float32), Rig(width, 2, 0.5, 1.0))
        assert np.isnan(_nearest(view, np.zeros(1))).all() == (width < 3)
    rows = [len(fitted_coefficients(replace(SMALL, horizon_row=row))) for row in (13.9, 14.4, 14.6)]
    assert rows == [4, 4, 4]
    told = [
        one for row in (13.0, 13.6, 14.0, 14.1, 14.5) for one in fitted_coefficients(replace(SMALL, horizon_row=row))
    ]
    as_before("just enough floor", {"told": told})


def test_matches_and_rays_are_enough_from_three_on() -> None:
    rng, told = np.random.default_rng(3), list[float]()
    rays = np.column_stack([rng.uniform(0, 6, 9), rng.normal(0, 0.2, 9), rng.uniform(0, 6, 9), rng.normal(0, 0.2, 9)])
    for n, weight, prior, window in itertools.product((2, 3, 9), (0.0, 0.5), (None, 0.3), (0.2, math.pi)):
        told += list(numbers(movement(Matches(rays[:n], np.full(n, weight)), prior, window, EpipolarSpec())))
    for prior, window in ((None, 0.1), (0.2, 0.01), (0.2, 0.3), (0.2, around(math.pi)[0]), (0.2, math.pi)):
        told += list(numbers(_grid(prior, window, EpipolarSpec(directions=4, rotations=6))))
    told += [float(v) for pair in _peaks(rng.random((9, 7)), 4) for v in pair]
    ring = np.full(36, np.nan, np.float32)
    for n in (2, 3, 4, 20):
        ring[: 3 * n : 3] = 1.0 + 0.1 * np.arange(len(ring[: 3 * n : 3]))
        for prior, window in ((0.0, 0.0), (0.3, 0.2), (0.0, math.pi)):
            told += list(numbers(places(ring, ring, prior, window, SearchSpec(rays=36))))[:20]
    as_before("enough matches", {"told": told})


def test_what_moved_by_itself_is_left_out_unless_that_is_most() -> None:
    there = np.array([1.0, 1.0, 1.0, 1.0])
    for towards, kept in ((BACK - 1e-9, [True, True, True, True]), (BACK + 1e-9, [True, True, False, False])):
        here = there + np.array([0.1, 0.2, -towards, -towards])
        assert still(there, here, math.pi).tolist() == kept
    assert still(there, there - np.array([-0.1, 0.5, 0.5, 0.5]), math.pi).all()


def test_the_convergence_point_is_come_to_in_steps_of_a_metre_at_most() -> None:
    marks, weights = np.array([[9.0, 0.0], [-7.0, 2.0], [0.5, -8.0]]), np.array([1.0, 2.0, 0.5])
    told = []
    for exponent, precision, rounds in itertools.product((1.0, 1.5, 2.0, 3.0), (1e-3, 0.3), (1, 3, 60)):
        told.append(convergence_point(marks, weights, exponent, precision, rounds))
    told.append(convergence_point(marks, np.zeros(3), 1.5))
    as_before("converged", {"told": np.array(told)})


def test_a_lean_is_stated_and_left_at_its_bounds() -> None:
    told = []
    for before, size, sigma, first in itertools.product(
        (0.0, 0.03), (*around(LEAST), *around(3 * 0.003), *around(0.006), 0.03, 0.03 - LEAST * 0.999, 0.024),
        (0.0, 0.002, 0.003), (0.002 / SURER, 0.004)
    ):  # fmt: skip
        mount = Mount()
        mount.lean, mount._sigma = Lean(before, 0.0), first
        told.append(mount._stated(Lean(size, 0.0), sigma).roll)
    assert MOUNT_CLEAR > FAINT
    for size, kept in zip(around(LEAST), (False, True, True), strict=True):
        assert (Mount(before=Lean(0.0, size)).lean != UPRIGHT) is kept
    as_before("leans stated", {"told": told})


def test_a_body_sways_at_its_bounds() -> None:
    told = []
    scale = 1.2816 * math.sqrt(2.0)
    for count, sharp, flicker, swayed in itertools.product(
        (ENOUGH - 1, ENOUGH), around(SHARP), (*around(SWAYS), *around(STILL), 0.0), (0.0, 0.01)
    ):
        mount = Mount()
        mount._spaced.extend((k % 2 * flicker * scale, 0.0) for k in range(count))
        mount._variances, mount._sway = [sharp**2] * 3, swayed
        told.append(mount._swaying())
    mount = Mount()
    mount.lean = Lean(0.01, 0.02)
    reading = LeanReading(Lean(0.05, -0.02), np.diag([4e-4, 1e-4]))
    assert mount.lean_at(reading) == mount.lean_at(None) == mount.lean
    mount._sway = 0.02
    assert mount.lean_at(reading) == Lean(0.01 + 0.5 * 0.04, 0.02 - 0.5 * 0.04)
    as_before("bodies sway", {"told": told})


def test_a_mount_is_known_from_so_many_readings_on(monkeypatch: pytest.MonkeyPatch) -> None:
    reading = LeanReading(Lean(0.001, 0.0), np.diag([1e-6, 1e-6]))
    monkeypatch.setattr(mount_file, "lean_of", lambda _: reading)
    mount, view = Mount(every=3), room(SMALL)
    for k in range(FIRST + 7):
        assert (mount.estimate is not None) is (k >= FIRST)
        taken = mount.see(view)
        assert (taken.said is not None) is (k < FIRST or k % 3 == 0)
    assert mount.estimate is not None
    assert not mount.estimate.taken_out
    for sigma, said in zip(around(TOO_VAGUE), (True, True, False), strict=True):
        reading = LeanReading(Lean(), np.diag([sigma**2, 0.0]))
        monkeypatch.setattr(LeanReading, "sigma", property(lambda _, s=sigma: s))
        assert (Mount()._said(view) is not None) is said


def test_edges_tell_a_lean_from_so_many_on_and_where_both_directions_are_seen() -> None:
    columns = np.linspace(0, 359, FEWEST + 1).astype(int)
    edges = np.column_stack([columns, 0.02 * np.cos(columns * TAU / 360), np.full(len(columns), 900.0)])
    assert [_fitted(edges[:n], 360, 1.0) is not None for n in (FEWEST - 1, FEWEST, FEWEST + 1)] == [False, True, True]
    narrow = edges.copy()
    for spread, seen in ((4, False), (40, True)):
        narrow[:, 0] = np.arange(len(narrow)) % spread
        assert (_fitted(narrow, 360, 1.0) is not None) is seen
    wide = room(Rig(verticals.COLUMNS + 40, 24, 11.5, 760 / TAU, 0.5))
    assert verticals._grey(wide).shape == (round(24 * 720 / 760), 722)


def test_eye_level_is_told_where_halves_agree_and_it_is_clear(monkeypatch: pytest.MonkeyPatch) -> None:
    view, told = room(SMALL), list[float]()
    monkeypatch.setattr(eye_level_file, "_matches", lambda *_: None)
    for far, peak, pairs in itertools.product((0, 1, 2), (*around(CLEAR), 0.0), (2, 3)):

        def votes(
            matches: list[object], _: float, __: float, rows: np.ndarray, p: float = peak, f: int = far
        ) -> object:
            found = np.full((len(matches), len(rows)), 1.0 / len(matches) if p else 0.0)
            found[0::2, 5] = found[1::2, 5 + f] = 2.0 * p / len(matches)
            return found

        monkeypatch.setattr(eye_level_file, "_votes", votes)
        found = eye_level([(view, view, 0.0)] * pairs)
        told += [9e3, 0.0] if found is None else [found.row, found.clear]
    assert eye_level([]) is None
    as_before("eye level bounds", {"told": told})


def test_auto_picks_at_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    view, rows = room(SMALL), list[str]()
    here, found = Auto(points=6.0), SimpleNamespace(rotation=0.2, support=0.4, direction=1.0, points=0.0, contrast=0.5)
    monkeypatch.setattr(auto, "EPIPOLAR", SimpleNamespace(movement=lambda *_: found, describe=lambda one: one))
    monkeypatch.setattr(auto, "home_of", lambda _: HomeVector(0.5, 1.0, 0.4))
    for found.points in (11.9, 12.0, 12.1):
        answer = here._pointed(view, view, 0.1)
        rows.append(
            "none" if answer is None else f"{answer.choice} {answer.evidence:.4f} {answer.alignment.residual:.2f}"
        )
    for residual, wider, confidence in itertools.product((0.2, 0.6, 0.9), (0.1, 0.5, 0.85), (0.0, 0.5)):

        class Near:
            """The near search, and by `replace` the wide one."""

            def __init__(self, told: float) -> None:
                self.told = told

            def align(self, *_: object, c: float = confidence) -> Alignment:
                return Alignment(self.told, self.told, HomeVector(0.1, 1.0, c))

        monkeypatch.setattr(auto, "NEAR", Near(residual))
        monkeypatch.setattr(auto, "replace", lambda *_, w=wider, **__: Near(w))
        rows.append(f"{residual} {wider} {confidence} {here._scanned(view, view, None, 0.1)}")
        rows.append(f"{auto._distance(view, view, 0.1)}")
    for evidence, sure in itertools.product((-1e3, -3.0, 0.0, 0.4, 2.0, 1e3), (0.0, 0.3)):
        for choice in auto.CALIBRATION:
            told = here._sure(choice, evidence, Alignment(0.1, 0.2, HomeVector(0.3, 1.0, sure)), view, view)
            rows.append(f"{choice} {told.alignment.home}")
    as_before("auto bounds", {"rows": rows})


def test_a_mirror_is_found_at_its_bounds() -> None:
    rng, told = np.random.default_rng(5), list[float]()
    radius = np.arange(4.0, 40.0, 0.5)
    for first, second in ((10, 60), (30, 36), (20, 32), (71, 0)):
        jump = rng.random(len(radius))
        jump[first], jump[second], jump[second - 1] = 9.0, 7.0, 5.0
        told += list(_rims((radius, jump)))
    grey = np.asarray(room(Rig(90, 60, 29.5, 90 / TAU)).image.mean(axis=2), np.float32)
    told += [_sharpness(grey, x, y) for x, y in ((45.0, 30.0), (11.9, 30.0), (12.0, 30.0), (45.0, 47.1), (45.0, 46.9))]
    for level, found in ((0, False), (1, False), (2, True)):
        raw = np.full((40, 40, 3), 50, np.uint8)
        raw[::2] += level + 1 if found else 0
        if not found:
            with pytest.raises(DataError):
                fit_mirror(raw)
    view = room(Rig(120, 20, 9.5, 120 / TAU))
    for inner, outer in ((8.0, 30.0), (5.0, 12.0), (0.0, 40.0)):
        rig = MirrorRig(45.0, 44.0, inner, outer, 0.7, "clockwise", False)
        told += list(numbers(unwrap(wrap_up(view, rig, (90, 90)), rig, view.rig).image))
    for inner, outer in ((-1e-9, 5.0), (5.0, 5.0)):
        with pytest.raises(DataError, match="0 <= inner < outer"):
            MirrorRig(1.0, 1.0, inner, outer)
    as_before("mirrors found", {"told": told})


def options() -> dict[str, object]:
    """Methods and aligners of the tables, each with one of its options set to something else."""
    made: dict[str, object] = {}
    for one in (*METHODS.values(), *ALIGNERS.values()):
        for field in fields(one) if is_dataclass(one) else ():
            value, kind = getattr(one, field.name), type(one).__name__
            other = not value if isinstance(value, bool) else value + 1 if isinstance(value, int) else 0.7 * value \
                if isinstance(value, float) else None  # fmt: skip
            if field.init and other is not None and f"{kind} {field.name}" not in made:
                made[f"{kind} {field.name}"] = replace(one, **{field.name: other})
    return made


def test_each_option_tells_as_much_as_before() -> None:
    rig = Rig(60, 20, 9.5, 60 / TAU, 0.5)
    here, there, found = room(rig), room(rig, 4.1, 3.1, 0.6), {}
    for name, one in options().items():
        told: list[float] = []
        try:
            if hasattr(one, "home"):
                told += numbers(one.home(one.describe(there), one.describe(here)))
            if hasattr(one, "align"):
                told += numbers(one.align(there, here, 0.3))
            found[name] = told
        except (DataError, ShapeError) as error:
            found[name] = [str(error)]
    as_before("options", found)


def test_columns_count_from_above_the_threshold_on() -> None:
    policy = METHODS_THAT_MOVE["run-down-threshold"]
    shares = np.array([*around(THRESHOLD), 0.9, 0.1, 0.61])
    told = [policy._one(a, b) for a, b in itertools.product((shares, shares[::-1]), (shares, np.roll(shares, 2)))]
    as_before("run down", {"told": np.array(told)})


def test_rows_about_the_horizon_and_cells_at_the_rim_count_as_before() -> None:
    told: list[float] = []
    for height, rows in itertools.product((20, 21, 1), (0.0, 0.04, 0.5, 1.0)):
        rig = Rig(30, height, (height - 1) / 2, 30 / TAU, 0.5)
        told += numbers(coloured(room(rig), 0.1, 0.2, rows))
    points = np.array([[0.8, -0.9], [-0.75, 0.7], [0.1, 0.0], [0.3, 1.1], [-1.3, 0.2]])
    assert [len(scan_search._table(np.array([[far, 0.0]]), 0.25)) for far in (5.0, 25.0, 40.0)] == [49, 209, 241]
    table = scan_search._nearness(points, 3, 0.25)
    told += numbers(table)
    told += table.ravel().tolist()
    told += scan_search._scores(table, points, np.arange(-4.0, 5.0) * 0.25, 0.25).ravel().tolist()
    as_before("rims", {"told": told})
