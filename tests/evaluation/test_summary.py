"""The summary's keys, its nulls and its file."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic_run import make_run

from topomap.core.run_data import Leg, TrueCalibration
from topomap.evaluation.summary import plain, summarise, table_rows, write_summary

RUN = make_run()
KEYS = {
    "world": None,
    "seed": None,
    "config": None,
    "distance_m": None,
    "steps": None,
    "steps_per_s": None,
    "snapshots": None,
    "closures": {"proposed", "accepted", "false", "gross", "possible", "recall", "false_ever", "recall_standing"},
    "dead_reckoning_ate_m": {"se2", "sim2"},
    "map_ate_m": {"se2", "sim2"},
    "online_ate_m": {"se2", "sim2"},
    "rotation_scale": {"true", "found", "sigma"},
    "distance_scale": {"true", "found", "sigma"},
    "curvature": {"true", "found", "sigma"},
    "home": {"asked", "claimed", "within_0_3_m", "error_m", "path_ratio", "shortest_ratio", "collisions"},
    "legs": None,
    "trust": {"kept", "way_noise", "turn_noise"},
    "mount": {"roll_deg", "pitch_deg", "sigma_deg", "sway_deg", "taken_out"},
    "graph_hash": None,
    "topology_hash": None,
    "fault": None,
    "log": {"state", "note"},
    "versions": None,
}


def test_exactly_the_promised_keys() -> None:
    summary = summarise(RUN)
    assert list(summary) == list(KEYS)
    for key, members in KEYS.items():
        if members is not None:
            part = summary[key]
            assert isinstance(part, dict)
            assert set(part) == members


def test_what_is_unknown_is_null_and_never_nan() -> None:
    bare = replace(
        RUN, truth=None, calibration=None, true_calibration=TrueCalibration(), replayed=True, seed=None,
        steps_per_s=None, config={"gain": math.nan, "size": np.float32(2.0), "path": Path("a")},
    )  # fmt: skip
    summary = json.loads(json.dumps(summarise(bare), allow_nan=False))
    assert set(summary["home"].values()) == {None}
    assert set(summary["map_ate_m"].values()) == {None}
    assert set(summary["curvature"].values()) == {None}
    assert summary["closures"]["proposed"] == 4
    assert summary["closures"]["false"] is None
    assert summary["config"] == {"gain": None, "size": 2.0, "path": "a"}
    assert summary["distance_m"] > 50
    assert all(text for _, text in table_rows(summary))


def test_an_unobserved_scale_was_not_found() -> None:
    assert summarise(RUN)["distance_scale"] == {"true": 0.95, "found": None, "sigma": 0.196}
    assert summarise(RUN)["rotation_scale"] == {"true": 1.04, "found": 1.036, "sigma": 0.008}


def test_a_run_that_was_stopped_before_its_first_step() -> None:
    nothing = np.zeros((0, 3))
    empty = replace(
        RUN, stamps_ns=np.zeros(0, dtype=np.int64), dead_reckoning=nothing, online=nothing, final=nothing,
        truth=None, driven=None, contact=None, nodes=(), decisions=(), goal_node=None,
    )  # fmt: skip
    summary = summarise(empty)
    assert summary["steps"] == 0
    assert summary["distance_m"] == 0.0
    assert table_rows(summary)


def test_the_table_says_the_main_things() -> None:
    rows = dict(table_rows(summarise(RUN)))
    assert rows["closures"] == "3 accepted of 4 proposed, 1 false (1 ever), 1 gross"
    assert rows["recall"].endswith("by standing closures without a margin")
    assert rows["distance scale"].startswith("unobserved")
    assert "within 0.3 m: no" in rows["home"]


def test_the_file_is_whole_or_not_there(tmp_path: Path) -> None:
    path = tmp_path / "out" / "summary.json"
    write_summary(path, summarise(RUN))
    written = path.read_bytes()
    assert json.loads(written)["world"] == "synthetic room"
    with pytest.raises(ValueError, match="JSON"):
        write_summary(path, {"speed": math.nan})
    assert path.read_bytes() == written
    assert [file.name for file in path.parent.iterdir()] == ["summary.json"]


def test_plain_values() -> None:
    assert plain({1: (np.int64(3), {"b", "a"}), "x": np.array([1.0, np.inf])}) == {
        "1": [3, ["a", "b"]],
        "x": [1.0, None],
    }


def test_a_patrol_is_a_row_that_tells_of_false_claims() -> None:
    assert "legs" not in dict(table_rows(summarise(RUN)))
    a, b = Leg(7, 120, 179, True, (1, 3)), Leg(6, 120, 175, False)
    rows = dict(table_rows(summarise(replace(RUN, legs=(a, b, replace(a, goal=6, last=140))))))
    assert rows["legs"].startswith("2 of 3 claimed, 2 falsely, ")
