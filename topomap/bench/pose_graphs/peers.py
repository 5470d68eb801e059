"""gtsam's optimisers on a pose graph in a process of their own, stopped when they take too long."""

from __future__ import annotations

import multiprocessing
import time
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.optimizer.peers import PEERS, inliers
from topomap.mapping.pose_graph import PoseGraph


class MethodRun(NamedTuple):
    """What one method makes of a graph.

    poses (N, 3), NaN if it failed; inlier (M,): the closures that it takes for true; seconds [s]: its optimising alone;
    cpu_seconds [s]: the processor's time for it, which is about the same when the machine is busy with other things;
    building_seconds [s]: making gtsam's graph, which is done factor by factor from Python and isn't the method's fault;
    whether it was stopped.
    """

    poses: FloatArray
    inlier: BoolArray
    seconds: float
    cpu_seconds: float
    building_seconds: float
    stopped: bool


class PeerProcess:
    """Runs peers one after the other, each for so many seconds at most, building apart; use it in a `with`."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._context = multiprocessing.get_context("spawn")
        self._process: SpawnProcess | None = None

    def __enter__(self) -> PeerProcess:
        return self

    def _start(self) -> None:
        self._here, there = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(there,), daemon=True)
        self._process.start()
        there.close()
        self._here.recv()  # it has imported all it needs: that isn't the peer's time

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._here.close()
            self._process = None

    def run(self, method: str, graph: PoseGraph) -> MethodRun:
        """Return what the peer makes of the graph; a stopped or failed one takes nothing for true."""
        if self._process is None:
            self._start()
        self._here.send((method, graph))
        building, begin = 0.0, time.perf_counter()
        try:
            building = self._here.recv()
            begin = time.perf_counter()
            if self._here.poll(self._limit):
                run: MethodRun = self._here.recv()
                return run
            stopped = True
        except EOFError:  # gtsam took the process down with it
            stopped = False
        seconds = time.perf_counter() - begin
        self.__exit__()
        return nothing(graph, seconds, building, stopped)


def nothing(graph: PoseGraph, seconds: float, building: float, stopped: bool) -> MethodRun:
    """Return what a method that was stopped, failed or wasn't asked makes of a graph."""
    nowhere = np.full((graph.nodes, 3), np.nan)
    return MethodRun(nowhere, np.zeros(len(graph.i), np.bool_), seconds, seconds, building, stopped)


def _serve(there: Connection) -> None:
    there.send("ready")
    while True:
        method, graph = there.recv()
        begin = time.perf_counter()
        built = PEERS[method].build(graph)
        building = time.perf_counter() - begin
        there.send(building)
        begin, worked = time.perf_counter(), time.process_time()
        try:
            found = PEERS[method].solve(built, graph.nodes)
            seconds, cpu = time.perf_counter() - begin, time.process_time() - worked
            run = MethodRun(*inliers(graph, found), seconds, cpu, building, False)
        except RuntimeError:  # gtsam gives up on an indeterminate system: a result of the peer, not an error of ours
            run = nothing(graph, time.perf_counter() - begin, building, stopped=False)
        there.send(run)
