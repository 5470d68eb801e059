"""False closures injected into a pose graph, all true ones kept, so that a given share of all closures is false.

The kinds are riSAM's (McGann et al. 2023): random, close by, groups that agree, and a mixture of these.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.errors import TopomapError
from topomap.core.evidence import FALSE_DISTANCE, FALSE_ROTATION
from topomap.core.geometry import between, compose, wrap_all
from topomap.mapping.pose_graph import PoseGraph

CLOSE_RADIUS = 10.0  # the ends of a false closure of the kind "close" lie within [m]
ROUNDS, FEWEST = 200, 1000  # how often, and how many at least, false closures are drawn until there are enough


class Kind(NamedTuple):
    """A simple kind of false closures: how many make a group, and how many nodes lie between two ends at least."""

    size: int
    apart: int


SIMPLE = {"random": Kind(1, 10), "close": Kind(1, 2), "groups-5": Kind(5, 10), "groups-10": Kind(10, 10)}
MIXTURE = {"random": 1 / 3, "close": 1 / 3, "groups-5": 1 / 6, "groups-10": 1 / 6}
KINDS = (*SIMPLE, "mixed")


@dataclass(frozen=True, slots=True, eq=False)
class Injected:
    """A pose graph with false (M,) telling which closures are false."""

    graph: PoseGraph
    false: BoolArray


class _Claims(NamedTuple):
    """n groups of s claims: i < j (n, s), relative (n, s, 3), like (n,): the true closure that each is made after."""

    i: IntArray
    j: IntArray
    relative: FloatArray
    like: IntArray

    def only(self, good: BoolArray) -> _Claims:
        """Return the groups (n,) that are good."""
        return _Claims(self.i[good], self.j[good], self.relative[good], self.like[good])


def wanted(true: int, share: float) -> int:
    """Return how many false closures make `share` of all false."""
    return round(true * share / (1.0 - share))


def inject(graph: PoseGraph, optimum: FloatArray, kind: str, share: float, rng: np.random.Generator) -> Injected:
    """Return the graph with false closures; optimum (N, 3): what tells false from true.

    A false closure claims the relative pose of a true one drawn evenly, with that one's covariance. Its ends are drawn
    evenly; for "close" they lie within 10 m of one another. In "groups-5" and "groups-10" the nodes that follow at
    both ends claim the same, in the same or the opposite direction of travel: in one group of two to the letter, as
    riSAM has it, in the other as odometry carries it on, with the noise of true closures. A claim that the optimum has
    within 1 m and 20 degrees is drawn again, with its group. True and false stand mixed. Raises TopomapError if the
    graph has no room for them.
    """
    true, drawer = len(graph.i), _Drawer(graph, optimum, rng)
    parts = [drawer.drawn(one, count) for one, count in _shares(kind, wanted(true, share))]
    i, j, relative, like = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = rng.permutation(true + len(i))
    mixed = replace(
        graph,
        i=np.concatenate([graph.i, i])[order],
        j=np.concatenate([graph.j, j])[order],
        relative=np.concatenate([graph.relative, relative])[order],
        covariance=np.concatenate([graph.covariance, graph.covariance[like]])[order],
    )
    return Injected(mixed, order >= true)


def _shares(kind: str, count: int) -> list[tuple[str, int]]:
    """Return which simple kinds make up a kind, and how many closures of each."""
    if kind != "mixed":
        return [(kind, count)]
    ends = np.round(np.cumsum([0.0, *MIXTURE.values()]) * count).astype(int)
    return list(zip(MIXTURE, np.diff(ends).tolist(), strict=True))


class _Drawer:
    """Draws false closures of one graph."""

    def __init__(self, graph: PoseGraph, optimum: FloatArray, rng: np.random.Generator) -> None:
        self._graph, self._optimum, self._rng = graph, optimum, rng
        self._poses = graph.dead_reckoning()
        self._chain = np.concatenate([np.zeros(1, np.int64), np.cumsum(graph.gaps)])
        self._noise = between(between(optimum[graph.i], optimum[graph.j]), graph.relative)

    def drawn(self, kind: str, count: int) -> tuple[IntArray, IntArray, FloatArray, IntArray]:
        """Return i, j (count,), relative (count, 3) and like (count,) of as many false closures of a simple kind."""
        size, have = SIMPLE[kind].size, 0
        found: list[_Claims] = []
        while have < count:
            if len(found) == ROUNDS:
                name = self._graph.name
                raise TopomapError(f"pose graph '{name}': no room for {count} false closures of the kind '{kind}'")
            claims = self._claims(kind, max(FEWEST, -(-(count - have) // size)))
            found.append(claims.only(_false(claims, self._optimum, SIMPLE[kind].apart)))
            have += found[-1].i.size
        i = np.concatenate([np.zeros(0, np.int64), *(part.i.ravel() for part in found)])
        j = np.concatenate([np.zeros(0, np.int64), *(part.j.ravel() for part in found)])
        relative = np.concatenate([np.zeros((0, 3)), *(part.relative.reshape(-1, 3) for part in found)])
        like = np.concatenate([np.zeros(0, np.int64), *(np.repeat(part.like, size) for part in found)])
        return i[:count], j[:count], relative[:count], like[:count]

    def _claims(self, kind: str, groups: int) -> _Claims:
        """Return so many groups of claims, true ones and impossible ones among them; those have i = j = 0."""
        like = self._rng.integers(0, len(self._graph.i), groups)
        if kind == "close":
            ends = np.sort(_near_ends(self._optimum, groups, self._rng), axis=1)
            apart = self._optimum[ends[:, 0], :2] - self._optimum[ends[:, 1], :2]
            ends[np.hypot(*apart.T) > CLOSE_RADIUS] = 0
        else:
            ends = np.sort(self._rng.integers(0, self._graph.nodes, (groups, 2)), axis=1)
        if SIMPLE[kind].size > 1:
            return self._grown(ends[:, 0], ends[:, 1], like, SIMPLE[kind].size)
        return _Claims(ends[:, :1], ends[:, 1:], self._graph.relative[like][:, None], like)

    def _grown(self, first_i: IntArray, first_j: IntArray, like: IntArray, size: int) -> _Claims:
        """Return groups (n, size) that begin with claims i, j (n,) and go on along both stretches."""
        back = self._rng.random(len(like)) < 0.5  # j's stretch is driven against i's, so it looks the other way there
        about = np.zeros((len(like), 3))
        about[back, 2] = np.pi
        claim = compose(self._graph.relative[like], about)
        along = np.arange(size)
        i, j = first_i[:, None] + np.where(back[:, None], -along, along), first_j[:, None] + along
        impossible = ~(self._one_stretch(i) & self._one_stretch(j))
        i[impossible], j[impossible] = 0, 0
        poses, same = self._poses, self._rng.random(len(like)) < 0.5
        carried = compose(between(poses[i], poses[i[:, :1]]), claim[:, None])
        carried = compose(carried, between(poses[j[:, :1]], poses[j]))
        noisy = compose(carried, self._noise[self._rng.integers(0, len(self._noise), i.shape)])
        return _Claims(i, j, np.where(same[:, None, None], claim[:, None], noisy), like)

    def _one_stretch(self, nodes: IntArray) -> BoolArray:
        """Return (n,) which stretches (n, size) lie within the graph and cross no gap."""
        last = np.clip(nodes[:, -1], 0, self._graph.nodes - 1)
        return np.asarray((last == nodes[:, -1]) & (self._chain[last] == self._chain[nodes[:, 0]]))


def _false(claims: _Claims, optimum: FloatArray, apart: int) -> BoolArray:
    """Return (n,) which groups are false in every claim, between nodes at least so many apart."""
    error = between(optimum[claims.i], optimum[claims.j]) - claims.relative
    far = np.hypot(error[..., 0], error[..., 1]) > FALSE_DISTANCE
    turned = np.abs(wrap_all(error[..., 2])) > FALSE_ROTATION
    return np.asarray(((claims.j - claims.i >= apart) & (far | turned)).all(axis=1))


def _near_ends(poses: FloatArray, count: int, rng: np.random.Generator) -> IntArray:
    """Return pairs (count, 2) of a node drawn evenly and one drawn evenly from the nine cells of 10 m around it."""
    cell = np.floor(poses[:, :2] / CLOSE_RADIUS).astype(np.int64)
    cell -= cell.min(axis=0) - 1
    wide = int(cell[:, 1].max()) + 2
    key = cell[:, 0] * wide + cell[:, 1]
    order = np.argsort(key, kind="stable")
    one = rng.integers(0, len(poses), count)
    around = key[one][:, None] + (np.arange(-1, 2)[:, None] * wide + np.arange(-1, 2)).ravel()
    first = np.searchsorted(key[order], around)
    upto = np.cumsum(np.searchsorted(key[order], around, side="right") - first, axis=1)
    pick = rng.integers(0, upto[:, -1])
    block = (pick[:, None] >= upto).sum(axis=1)
    row = np.arange(count)
    before = np.where(block > 0, upto[row, block - 1], 0)
    return np.column_stack([one, order[first[row, block] + pick - before]])
