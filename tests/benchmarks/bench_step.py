"""A step, sense to command and without rendering, while `campus` is taught: CPU time by stage as the map grows."""

from __future__ import annotations

import time

import numpy as np

from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator
from topomap.navigation import stopwatch

Row = dict[str, str | float | None]
NODES, FIRST = 2_500, 2_000  # of the map in the end, and from which on steps count [nodes]


def rows() -> list[Row]:
    """Return the mean of every stage, and 50 %, 99 % and worst of whole steps, all with FIRST nodes and more."""
    config = RunConfig()
    robot = SimRobot(worlds.load("campus"), config.sim, 1)
    warm_up(config.stack)
    navigator = build_navigator(config.stack)
    stages: list[dict[str, float]] = []
    clock, stopwatch.time.perf_counter = stopwatch.time.perf_counter, time.process_time
    try:
        while len(navigator.mapper.map.nodes) < NODES and (reading := robot.sense()) is not None:
            command, record = navigator.step(reading)
            robot.act(command)
            if len(navigator.mapper.map.nodes) >= FIRST:
                stages.append(dict(record.timings))
    finally:
        stopwatch.time.perf_counter = clock
    whole = np.array([sum(one.values()) for one in stages])
    size = f"CPU time, campus seed 1, {len(whole)} steps at {FIRST} to {NODES} nodes"
    told = [
        ("mean", whole.mean()),
        ("p50", np.median(whole)),
        ("p99", np.quantile(whole, 0.99)),
        ("worst", whole.max()),
    ]
    told += [(f"mean, {stage}", np.mean([one[stage] for one in stages])) for stage in stages[0]]
    return [{"name": f"step, {name}", "ms": float(ms), "size": size} for name, ms in told]
