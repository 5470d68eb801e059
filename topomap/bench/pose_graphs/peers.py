"""gtsam's optimisers on a pose graph in a process of their own, stopped when they take too long."""

from __future__ import annotations

import multiprocessing
import time
from multiprocessing.connection import Connection
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.optimizer import Closures
from topomap.mapping.optimizer.peers import PEERS
from topomap.mapping.pose_graph import PoseGraph


class PeerRun(NamedTuple):
    """Poses (N, 3), NaN if the peer failed; the believed closures (M,); its own time [s]; whether it was stopped."""

    poses: FloatArray
    believed: BoolArray
    seconds: float
    stopped: bool


class PeerProcess:
    """Runs peers one after the other, each for so many seconds at most; use it in a `with`."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._context = multiprocessing.get_context("spawn")

    def __enter__(self) -> PeerProcess:
        self._here, there = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(there,), daemon=True)
        self._process.start()
        there.close()
        self._here.recv()  # it has imported all it needs: that isn't the peer's time
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.join()
        self._here.close()

    def run(self, method: str, graph: PoseGraph) -> PeerRun:
        """Return what the peer makes of the graph; a stopped or failed one believes nothing."""
        self._here.send((method, graph))
        begin = time.perf_counter()
        stopped = not self._here.poll(self._limit)
        try:
            if not stopped:
                run: PeerRun = self._here.recv()
                return run
        except EOFError:  # gtsam took the process down with it
            pass
        seconds = time.perf_counter() - begin
        self.__exit__()
        self.__enter__()
        return _nothing(graph, seconds, stopped)


def closures_of(graph: PoseGraph) -> Closures:
    """Return the graph's closures as the back end takes them."""
    return Closures(graph.i, graph.j, graph.relative, graph.covariance, np.ones(len(graph.i)))


def _nothing(graph: PoseGraph, seconds: float, stopped: bool) -> PeerRun:
    return PeerRun(np.full((graph.nodes, 3), np.nan), np.zeros(len(graph.i), bool), seconds, stopped)


def _serve(there: Connection) -> None:
    there.send("ready")
    while True:
        method, graph = there.recv()
        begin = time.perf_counter()
        try:
            found = PEERS[method](graph.odometry, graph.odometry_covariance, closures_of(graph))
            run = PeerRun(found.poses, found.believed, time.perf_counter() - begin, False)
        except RuntimeError:  # gtsam gives up on an indeterminate system: a result of the peer, not an error of ours
            run = _nothing(graph, time.perf_counter() - begin, stopped=False)
        there.send(run)
