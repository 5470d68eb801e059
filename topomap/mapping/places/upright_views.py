"""Views taken upright: a drive's camera lean found, taken out of each view, and of those that were kept before."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.core.records import MountLean
from topomap.mapping.graph import TopoMap
from topomap.vision.tilt.lean import UPRIGHT, Lean
from topomap.vision.tilt.mount import Mount, Taken
from topomap.vision.tilt.upright import upright
from topomap.vision.tilt.verticals import LeanReading


class UprightViews:
    """Takes the lean out of the views of one drive; snapshots keep what the camera took, and their rig how it leant.

    restated: whether the last view changed what is known of the mount, so that kept views have to be taken anew.
    """

    def __init__(self, topo: TopoMap) -> None:
        """topo: where it holds views already, the camera is taken to lean as theirs did until its own views tell."""
        self._map = topo
        self._mount = Mount(before=_usual(topo))
        self._raw: Panorama | None = None
        self._before: Panorama | None = None
        self._taken = Taken(None, UPRIGHT)
        self._last: tuple[int, Panorama | None] = (-1, None)
        self._kept: dict[int, tuple[LeanReading | None, Lean]] = {}

    @property
    def restated(self) -> bool:
        """Whether the last view changed what is known of the mount."""
        return self._mount.restated

    @property
    def estimate(self) -> MountLean | None:
        """What is known of the mount, None where too little is."""
        return self._mount.estimate

    @property
    def said(self) -> str:
        """What was newly found by the last view, in plain words, "" for nothing."""
        if not self.restated or (found := self.estimate) is None:  # the estimate costs a median over all readings
            return ""
        roll, pitch, sigma, sway = (math.degrees(a) for a in (found.roll, found.pitch, found.sigma, found.sway))
        moves = f" and sways by {sway:.1f}" if sway else ""
        taken = "views are taken upright" if found.taken_out else "views are left as they are"
        return f"the camera leans {roll:.1f} right, {pitch:.1f} forward (± {sigma:.1f} degrees){moves}: {taken}"

    def see(self, raw: Panorama) -> Panorama:
        """Learn from a view as the camera took it, and return it upright."""
        self._before, self._raw = self._raw, raw
        self._taken = self._mount.see(raw)
        return upright(raw, self._taken.lean)

    def before(self) -> Panorama | None:
        """Return the view before the last one as it is taken upright now."""
        return None if self._before is None else upright(self._before, self._mount.lean)

    def leaning(self, rig: RecordedRig) -> RecordedRig:
        """Return the rig with the lean of the last view."""
        return replace(rig, roll=self._taken.lean.roll, pitch=self._taken.lean.pitch)

    def keep(self, node: int, already: bool) -> None:
        """Remember what the last view said, as a node keeps it; already: it is kept as it was taken upright."""
        self._kept[node] = (self._taken.said, self._taken.lean if already else UPRIGHT)
        self._last = (node, self._raw)

    def last_kept(self) -> tuple[int, Panorama] | None:
        """Return the last node that was kept, and its whole view as it is taken upright now."""
        node, raw = self._last
        return None if raw is None else (node, upright(raw, self._mount.lean_at(self._kept[node][0])))

    def restate(self) -> tuple[int, ...]:
        """Tell the rigs of all kept views how the camera leant, as it is known now; return their nodes."""
        for node, (said, out) in self._kept.items():
            lean = self._mount.lean_at(said) - out
            self._map.lean(node, lean.roll, lean.pitch)
        return tuple(self._kept)


def _usual(topo: TopoMap) -> Lean:
    """Return how the middle one of a map's views leant."""
    rigs = [node.snapshot.rig for node in topo.nodes if node.snapshot is not None]
    if not rigs:
        return UPRIGHT
    roll, pitch = np.median([(rig.roll, rig.pitch) for rig in rigs], axis=0).tolist()
    return Lean(roll, pitch)
