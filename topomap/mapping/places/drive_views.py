"""A drive's views as the map keeps them: taken upright, made as small as asked, kept, taken anew when more is known."""

from __future__ import annotations

from collections.abc import Iterator

from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.core.records import MountLean
from topomap.core.robot import Reading
from topomap.core.view_size import parse_view
from topomap.mapping.graph import Snapshot, TopoMap
from topomap.mapping.places.small_view import small_view, snapshot_of
from topomap.mapping.places.upright_views import UprightViews
from topomap.mapping.places.view_cache import ViewCache


class DriveViews:
    """Makes of what the camera took what place search, compass and homing compare.

    cache: the map's views; whole: the last two as they were before they were made small.
    """

    def __init__(self, topo: TopoMap) -> None:
        """topo: says how large its views are."""
        self._size = parse_view(topo.view)
        self._upright = UprightViews(topo)
        self._last: Panorama | None = None
        self.cache = ViewCache(topo)
        self.whole = ViewCache(topo, 2)

    @property
    def restated(self) -> bool:
        """Whether the last view changed what is known of the camera, so that `restate` is due."""
        return self._upright.restated

    @property
    def said(self) -> str:
        """What was newly found of the camera by the last view, in plain words, "" for nothing."""
        return self._upright.said

    @property
    def mount(self) -> MountLean | None:
        """How the camera leans, None where too few views have shown it."""
        return self._upright.estimate

    def see(self, raw: Panorama, turn: float) -> Panorama:
        """Return a view upright, whole and as small as the map's are; to be asked once for each reading.

        turn: since the one before, by the odometry [rad].
        """
        self._last = self._upright.see(raw, turn)
        return self._small(self._last)

    def restate(self) -> Iterator[tuple[int, Panorama]]:
        """Take this drive's kept views anew as the camera is known now; yield nodes and their views."""
        nodes = self._upright.restate()
        for node in nodes:
            self.cache.drop(node)
            self.whole.drop(node)
        last = self._upright.last_kept()
        if last is not None:
            self.whole.put(*last)
        for node in nodes:
            yield node, self.cache.panorama(node)

    def before(self) -> Panorama | None:
        """Return the view before the last one as it is taken now."""
        before = self._upright.before()
        return None if before is None else self._small(before)

    def snapshot(self, reading: Reading, panorama: Panorama) -> Snapshot:
        """Return what is stored of a reading, seen as `panorama`."""
        if self._size is not None and reading.rig.width > self._size.columns:
            return snapshot_of(panorama)
        return Snapshot(reading.encoded, reading.ranges, self._upright.leaning(RecordedRig.of(reading.rig)))

    def keep(self, node: int, snapshot: Snapshot, reading: Reading, panorama: Panorama) -> None:
        """Keep a node's view that is at hand, and remember how the camera was."""
        self._upright.keep(node, already=snapshot.encoded is not reading.encoded)
        self.cache.put(node, panorama)
        self.whole.put(node, self._last or panorama)

    def _small(self, panorama: Panorama) -> Panorama:
        return panorama if self._size is None else small_view(panorama, self._size)
