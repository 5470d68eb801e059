"""Views taken upright and whole: what the robot hides of them and how its camera leans is found and taken out, of each
view and of those that were kept before."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig, Spans
from topomap.core.records import MountLean
from topomap.mapping.graph import TopoMap
from topomap.vision.occlusion.filled import filled
from topomap.vision.occlusion.self_occlusion import SelfOcclusion
from topomap.vision.tilt.lean import UPRIGHT, Lean
from topomap.vision.tilt.mount import Mount, Taken
from topomap.vision.tilt.upright import upright
from topomap.vision.tilt.verticals import LeanReading


class UprightViews:
    """Takes the lean and what the robot hides out of the views of one drive; snapshots keep what the camera took, and
    their rig how it leant and what was hidden.

    restated: whether the last view changed what is known of these, so that kept views have to be taken anew.
    """

    def __init__(self, topo: TopoMap) -> None:
        """topo: where it holds views already, the camera is taken for theirs until its own views tell."""
        self._map = topo
        self._mount = Mount(before=_usual(topo))
        self._occlusion = SelfOcclusion(before=_usually_hidden(topo))
        self._raw: Panorama | None = None
        self._before: Panorama | None = None
        self._taken = Taken(None, UPRIGHT)
        self._last: tuple[int, Panorama | None] = (-1, None)
        self._kept: dict[int, tuple[LeanReading | None, Lean, Spans]] = {}

    @property
    def restated(self) -> bool:
        """Whether the last view changed what is known of the camera."""
        return self._mount.restated or self._occlusion.changed

    @property
    def estimate(self) -> MountLean | None:
        """What is known of the mount, None where too little is."""
        return self._mount.estimate

    @property
    def said(self) -> str:
        """What was newly found by the last view, in plain words, "" for nothing."""
        if self._occlusion.changed:
            return _said_hidden(self._occlusion.spans)
        if not self._mount.restated or (found := self.estimate) is None:  # it costs a median over all readings
            return ""
        roll, pitch, sigma, sway = (math.degrees(a) for a in (found.roll, found.pitch, found.sigma, found.sway))
        moves = f" and sways by {sway:.1f}" if sway else ""
        taken = "views are taken upright" if found.taken_out else "views are left as they are"
        return f"the camera leans {roll:.1f} right, {pitch:.1f} forward (± {sigma:.1f} degrees){moves}: {taken}"

    def see(self, raw: Panorama, turn: float) -> Panorama:
        """Learn from a view as the camera took it, and return it upright and whole; turn: by the odometry [rad]."""
        self._before, self._raw = self._raw, raw
        self._occlusion.see(raw, turn)
        whole = self._whole(raw)
        self._taken = self._mount.see(whole)
        return upright(whole, self._taken.lean)

    def _whole(self, raw: Panorama) -> Panorama:
        return filled(raw, self._occlusion.spans)

    def before(self) -> Panorama | None:
        """Return the view before the last one as it is taken upright now."""
        return None if self._before is None else upright(self._whole(self._before), self._mount.lean)

    def leaning(self, rig: RecordedRig) -> RecordedRig:
        """Return the rig with the lean of the last view and what was hidden of it."""
        lean = self._taken.lean
        return replace(rig, roll=lean.roll, pitch=lean.pitch, hidden=self._occlusion.spans)

    def keep(self, node: int, already: bool) -> None:
        """Remember what the last view said, as a node keeps it; already: it is kept upright and whole."""
        out = (self._taken.lean, self._occlusion.spans) if already else (UPRIGHT, ())
        self._kept[node] = (self._taken.said, *out)
        self._last = (node, self._raw)

    def last_kept(self) -> tuple[int, Panorama] | None:
        """Return the last node that was kept, and its whole view as it is taken upright now."""
        node, raw = self._last
        return None if raw is None else (node, upright(self._whole(raw), self._mount.lean_at(self._kept[node][0])))

    def restate(self) -> tuple[int, ...]:
        """Tell the rigs of all kept views how the camera leant and what was hidden, as is known now; return their
        nodes."""
        hidden = self._occlusion.spans
        for node, (said, out, whole) in self._kept.items():
            lean = self._mount.lean_at(said) - out
            self._map.restate(node, lean.roll, lean.pitch, () if whole == hidden else hidden)
        return tuple(self._kept)


def _usual(topo: TopoMap) -> Lean:
    """Return how the middle one of a map's views leant."""
    rigs = [node.snapshot.rig for node in topo.nodes if node.snapshot is not None]
    if not rigs:
        return UPRIGHT
    roll, pitch = np.median([(rig.roll, rig.pitch) for rig in rigs], axis=0).tolist()
    return Lean(roll, pitch)


def _usually_hidden(topo: TopoMap) -> Spans:
    """Return what was hidden in most of a map's views that tell: small ones are kept whole."""
    snapshots = [node.snapshot for node in topo.nodes if node.snapshot is not None]
    spans = Counter(snapshot.rig.hidden for snapshot in snapshots if snapshot.rig.hidden)
    return spans.most_common(1)[0][0] if spans else ()


def _said_hidden(spans: Spans) -> str:
    if not spans:
        return "the robot hides nothing of its view any more"
    wide = sum(extent for _, extent in spans)
    parts = "a part" if len(spans) == 1 else f"{len(spans)} parts"
    return f"the robot hides {parts} of its view, {math.degrees(wide):.0f} degrees: filled from beside"
