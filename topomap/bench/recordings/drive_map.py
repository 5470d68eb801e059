"""A drive's folder through the mapper alone, without a log: what a bench judges."""

from __future__ import annotations

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import MapChange
from topomap.core.run_data import NodeData, RunData, TrueCalibration
from topomap.datasets.drive_folder import DriveFolder, FolderRobot
from topomap.mapping.mapper import Mapper, MapperSettings
from topomap.vision.registry import aligner

NOBODY = TrueCalibration()


def map_readings(drive: DriveFolder, settings: MapperSettings, known: TrueCalibration = NOBODY) -> RunData:
    """Take a drive through the mapper; known: the odometer's true errors. Raises DataError."""
    mapper = Mapper(settings, aligner(settings.aligner))
    robot = FolderRobot(drive)
    online, raw, stamps, truths = [], [], [], []
    while (reading := robot.sense()) is not None:
        change: MapChange = mapper.update(reading, mapper.seen(Panorama.from_reading(reading)))
        online.append(change.pose.array())
        raw.append(mapper.track.raw.array())
        stamps.append(reading.stamp_ns)
        truth = robot.truth()
        truths.append((np.nan,) * 3 if truth is None else (truth.x, truth.y, truth.heading))
    mapper.finish(stamps[-1])
    at, poses = mapper.map.trajectory()
    final = poses[np.searchsorted(at, np.array(stamps, np.int64))]
    nodes = tuple(
        NodeData(k, node.stamp_ns, mapper.map.pose(k).array(), node.snapshot is not None)
        for k, node in enumerate(mapper.map.nodes)
    )
    return RunData(
        world=drive.name, seed=None, config={}, versions={}, stamps_ns=np.array(stamps, np.int64),
        dead_reckoning=np.array(raw), online=np.array(online), final=final,
        truth=None if drive.table.truth is None else np.array(truths), nodes=nodes,
        decisions=tuple(mapper.ledger.decisions), calibration=mapper.optimisation.state, true_calibration=known,
        graph_hash=mapper.graph_hash(), trust=mapper.optimisation.trust, mount=mapper.mount,
    )  # fmt: skip
