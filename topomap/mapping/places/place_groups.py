"""Places as groups of snapshots that look alike and lie together, as place cells have it (thesis 6.4.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, Complex64Array, FloatArray
from topomap.mapping.graph import TopoMap
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.image.compare import Signature, rotation_differences, signature

ALIKE = 0.8
"""Difference to a place's first view below which its cell fires: at the place it is 0.42 to 0.87 at 0.3 m and 0.75 or
more from 1 m on, over 75 places of room-corridor, hall and office-loop."""
FIELD = 1.0
"""[m] How far from its first snapshot a place reaches on the map: from there on other places look no less alike."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceGroups:
    """Places of a map: members, the snapshot nodes of each of G places, the first of them its centre; spectra
    (G, R, C) of the centres' views.
    """

    members: tuple[tuple[int, ...], ...]
    spectra: Complex64Array

    def code(self, view: Signature) -> BoolArray:
        """Return which places' cells (G,) fire at a view, turned any way: a binary code of where it was taken."""
        if not self.members:
            return np.zeros(0, bool)
        fires: BoolArray = rotation_differences(view, self.spectra).difference < ALIKE
        return fires

    def candidates(self, view: Signature) -> list[int]:
        """Return the snapshot nodes of all places that fire, those of the best one first."""
        if not self.members:
            return []
        differences = rotation_differences(view, self.spectra).difference
        firing = [k for k in np.argsort(differences, kind="stable").tolist() if differences[k] < ALIKE]
        return [node for k in firing for node in self.members[k]]


def group_places(topo: TopoMap, views: ViewCache | None = None) -> PlaceGroups:
    """Group a map's snapshots in the order they were taken: each joins the place it looks most like among those whose
    field it lies in, or is the first of a new one. Raises DataError for a view that can't be decoded.
    """
    cache = views or ViewCache(topo)
    nodes = [k for k, node in enumerate(topo.nodes) if node.snapshot is not None]
    members: list[list[int]] = []
    spectra: list[Complex64Array] = []
    for node in nodes:
        view = signature(cache.panorama(node))
        near = _near(topo.poses, [own[0] for own in members], node)
        k = _most_alike(view, spectra, near)
        if k is None:
            members.append([node])
            spectra.append(view.spectrum)
        else:
            members[k].append(node)
    stack = np.stack(spectra) if spectra else np.zeros((0, 0, 0), np.complex64)
    return PlaceGroups(tuple(map(tuple, members)), stack)


def _near(poses: FloatArray, centres: Sequence[int], node: int) -> list[int]:
    """Return which centres' fields a node lies in."""
    if not centres:
        return []
    away = np.hypot(*(poses[list(centres), :2] - poses[node, :2]).T)
    return np.flatnonzero(away < FIELD).tolist()


def _most_alike(view: Signature, spectra: Sequence[Complex64Array], among: Sequence[int]) -> int | None:
    if not among:
        return None
    differences = rotation_differences(view, np.stack([spectra[k] for k in among])).difference
    best = int(differences.argmin())
    return among[best] if differences[best] < ALIKE else None
