from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map
from topomap.mapping.places.place_groups import ALIKE, FIELD, PlaceGroups, group_places
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.image.compare import rotation_difference, signature

GOLDEN = Path(__file__).parents[1] / "golden" / "first-house.topomap"


@pytest.fixture(scope="module")
def drive() -> tuple[TopoMap, ViewCache, PlaceGroups]:
    topo = load_map(GOLDEN)
    views = ViewCache(topo)
    return topo, views, group_places(topo, views)


def test_every_snapshot_belongs_to_one_place_alike_and_near(drive: tuple[TopoMap, ViewCache, PlaceGroups]) -> None:
    topo, views, groups = drive
    snapshots = [k for k, node in enumerate(topo.nodes) if node.snapshot is not None]
    assert sorted(node for own in groups.members for node in own) == snapshots
    assert 1 < len(groups.members) < len(snapshots)
    for own in groups.members:
        for node in own[1:]:
            assert np.hypot(*(topo.poses[node, :2] - topo.poses[own[0], :2])) < FIELD
            assert rotation_difference(*(signature(views.panorama(k)) for k in (node, own[0])))[0] < ALIKE


def test_a_view_turned_any_way_fires_the_cell_of_its_place(drive: tuple[TopoMap, ViewCache, PlaceGroups]) -> None:
    _, views, groups = drive
    for place, own in list(enumerate(groups.members))[::5]:
        turned = views.panorama(own[0]).rolled(37)
        assert groups.code(signature(turned))[place]
        assert groups.candidates(signature(turned))[: len(own)] == list(own)


def test_what_was_never_seen_fires_nothing(drive: tuple[TopoMap, ViewCache, PlaceGroups]) -> None:
    rig = Rig()
    noise = np.random.default_rng(0).integers(0, 255, (rig.height, rig.width, 3)).astype(np.uint8)
    seen = signature(Panorama(noise, None, rig))
    assert not drive[2].code(seen).any()
    assert drive[2].candidates(seen) == []
    empty = PlaceGroups((), np.zeros((0, 0, 0), np.complex64))
    assert (empty.candidates(seen), len(empty.code(seen))) == ([], 0)
