"""The map as it goes into a log: the finished one, and how it stands for viewers."""

from __future__ import annotations

from topomap.core.records import Phase, StepRecord
from topomap.mapping.graph import TopoMap
from topomap.navigation.navigator import Navigator
from topomap.recording.recorder import FinalMap, MapNow


def final_map(navigator: Navigator, last: StepRecord, steps_per_s: float) -> FinalMap:
    """Return the finished map, what it makes of its evidence, and what came of the journey after the last step."""
    mapper = navigator.mapper
    topo = mapper.map
    stamps, poses = topo.trajectory(mapper.first)
    travel = last.travel.phase
    asked = last.goal.phase is Phase.TRAVEL
    return FinalMap(
        stamps,
        poses,
        tuple((i, n.stamp_ns, topo.pose(i), n.snapshot is not None) for i, n in enumerate(topo.nodes)),
        _edges(topo),
        mapper.optimisation.state,
        mapper.graph_hash(),
        steps_per_s,
        travel is Phase.ARRIVED if asked else None,
        last.goal.node,
        trust=mapper.optimisation.trust,
        mount=mapper.mount,
        topology_hash=mapper.topology_hash(),
    )


def map_now(topo: TopoMap) -> MapNow:
    """Return the map as it stands, for viewers."""
    return MapNow(tuple((i, topo.pose(i), n.snapshot is not None) for i, n in enumerate(topo.nodes)), _edges(topo))


def _edges(topo: TopoMap) -> tuple[tuple[int, int, str], ...]:
    return tuple((a, b, data["kind"]) for a, b, data in topo.graph.edges(data=True))
