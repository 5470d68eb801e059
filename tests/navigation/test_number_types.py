"""A robot may hand over NumPy's numbers or plain ones: the same drive gives the same map and the same log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from played import Played, taught

from logs.recorder import Recorder
from sim2d.records import SimReading
from topomap.app.config import load_config
from topomap.app.final_map import map_now
from topomap.app.wiring import build_navigator
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map, save_map
from topomap.navigation.runner import run
from topomap.recording.encode import run_header
from topomap.recording.recorder import RunRecorder
from topomap.recording.run_reader import load_run

STEPS = 215  # so far that the loop is closed


@pytest.fixture(scope="module")
def readings() -> list[SimReading]:
    """Numbers that a float32 holds exactly, so that every type can say the same."""
    return [typed(reading, np.float32, float) for reading in taught(STEPS)]


@pytest.fixture(scope="module")
def plain(readings: list[SimReading]) -> tuple[TopoMap, str]:
    return driven(readings)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_the_hash_is_the_same_whatever_kind_of_numbers(
    kind: Callable[[float], float], readings: list[SimReading], plain: tuple[TopoMap, str], tmp_path: Path
) -> None:
    topo, digest = driven([typed(reading, kind, kind) for reading in readings], tmp_path / "run.mcap")
    assert plain[0].closures
    assert topo.poses.tobytes() == plain[0].poses.tobytes()
    assert digest == plain[1]
    assert all(type(node.travel) is float and type(node.stamp_ns) is int for node in topo.nodes)
    assert len(load_run(tmp_path / "run.mcap").stamps_ns) == STEPS
    save_map(topo, tmp_path / "a.topomap")
    assert load_map(tmp_path / "a.topomap").hash([]) == topo.hash([])


def driven(readings: list[SimReading], log: Path | None = None) -> tuple[TopoMap, str]:
    config = load_config()
    navigator = build_navigator(config.stack)
    topo = navigator.mapper.map
    if log is None:
        run(Played(readings), navigator, ())
    else:
        with Recorder(log, run_header("room", readings[0].rig)) as recorder:
            run(Played(readings), navigator, (RunRecorder(recorder, lambda: map_now(topo)),))
    navigator.mapper.finish(readings[-1].stamp_ns)
    return topo, navigator.mapper.graph_hash()


def typed(reading: SimReading, rounded: Callable[[float], float], kind: Callable[[Any], Any]) -> SimReading:
    """The reading with numbers rounded as one type and handed over as another; NumPy's kinds for arrays, too."""
    plain, motion = kind is float, reading.motion
    numbers = {name: kind(rounded(getattr(motion, name))) for name in ("forward", "left", "turn", "dt")}
    covariance = motion.covariance.astype(np.float32).astype(np.float64 if plain else kind)
    ranges = None if reading.ranges is None else reading.ranges.astype(np.float32 if plain else np.float64)
    stamp = int(reading.stamp_ns) if plain else np.int64(reading.stamp_ns)
    return replace(
        reading, stamp_ns=stamp, ranges=ranges, motion=replace(motion, covariance=covariance, **numbers),
        driven=reading.driven if plain else np.bool_(reading.driven),
    )  # fmt: skip
