"""A recorded drive with claims "the same place" through the closure engine."""

from __future__ import annotations

from typing import NamedTuple

from topomap.core.arrays import FloatArray
from topomap.mapping.closures.along_drive import map_along
from topomap.mapping.closures.along_settings import AlongSettings as AlongSettings
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.place_claims import PlaceClaims
from topomap.mapping.recorded_drive import RecordedDrive


class DriveMap(NamedTuple):
    """A mapped drive: poses (N, 3) of its nodes, online (K + 1, 3) at its stamps as known then, the odometry's
    calibration with covariance (3, 3) and what was unknown of it before, and the verdicts.
    """

    poses: FloatArray
    online: FloatArray
    calibration: Calibration
    calibration_covariance: FloatArray
    prior_sigmas: tuple[float, float, float]
    ledger: Ledger


def map_drive(drive: RecordedDrive, claims: PlaceClaims, settings: AlongSettings | None = None) -> DriveMap:
    """Map a drive; claims that may be false are weighed as the drive goes on."""
    mapping, solution = map_along(drive, claims, settings or AlongSettings())
    return DriveMap(
        solution.poses,
        mapping.online,
        solution.calibration,
        solution.calibration_covariance,
        mapping.prior_sigmas,
        mapping.ledger,
    )
