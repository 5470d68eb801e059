"""How firmly a recording's map stands: what is varied, and what comes of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from drives import laps, write_recording

from topomap.app import recordings
from topomap.bench.recordings.stability import RecordingTask, moved_settings, thinned, variations, worst
from topomap.datasets.tuc.recording import read_tuc
from topomap.mapping.drive_engine import AlongSettings


@pytest.fixture
def square(tmp_path: Path) -> Path:
    return write_recording(tmp_path, *laps())


def test_every_number_is_moved_by_a_fifth_either_way() -> None:
    base = AlongSettings()
    moved = dict(moved_settings(base))
    assert moved["closure_sigma +20 %"].closure_sigma == pytest.approx(1.2 * base.closure_sigma)
    assert moved["growing.cutoffs -20 %"].growing.cutoffs == pytest.approx([0.8 * c for c in base.growing.cutoffs])
    assert moved["gate.probability +20 %"].gate.probability == pytest.approx(1 - 1.2 * (1 - base.gate.probability))
    assert moved["closing.iterations -20 %"].closing.iterations == round(0.8 * base.closing.iterations)
    everything = moved["all at once +20 %"]
    assert everything.every == pytest.approx(1.2 * base.every)
    assert everything.support.window == pytest.approx(1.2 * base.support.window)
    assert not any(settings.building_axes for settings in moved.values())
    assert len({settings.model_dump_json() for settings in moved.values()}) == len(moved)


def test_a_tenth_is_a_tenth_and_its_draw_decides_it(square: Path) -> None:
    recording = read_tuc(square)
    some = thinned(recording, 0.1, np.random.default_rng(1))
    assert len(some.query_ns) == len(some.match_ns) == len(some.similarity) == round(0.1 * len(recording.query_ns))
    assert (np.diff(some.query_ns) >= 0).sum() >= len(some.query_ns) - 2, "the file's order: two runs of candidates"
    other = thinned(recording, 0.1, np.random.default_rng(2))
    assert not np.array_equal(some.query_ns, other.query_ns)


def test_rows_say_what_was_kept_and_how_far_off_it_was(square: Path, tmp_path: Path) -> None:
    which = [v for v in variations() if v.group in ("as it is", "start")]
    rows = recordings.bench(square, which, 1, lambda _: None)
    assert [row.group for row in rows] == ["as it is", "start", "start"]
    assert all(row.se2_m is not None and row.se2_m < 1.0 and row.false == 0 and row.kept > 50 for row in rows)
    assert RecordingTask(square, which[0]).perform().se2_m == rows[0].se2_m
    (_, _, best, last), *_ = worst([row for row in rows if row.group == "start"])
    assert (best.se2_m or 0) <= (last.se2_m or 0)
    written = recordings.write_bench(rows, tmp_path / "out")
    assert len(json.loads(written[0].read_text())) == 3
    assert written[1].read_text().count("\n") == 4
    assert written[2].stat().st_size > 5_000
