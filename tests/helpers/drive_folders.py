"""A drive of panoramas in a folder, as somebody's recording would be."""

from __future__ import annotations

import json
import math
from pathlib import Path

from round_world import RIG, RoundRobot

from topomap import Pose2

HEAD = "stamp_s,x_m,y_m,heading_rad,image"


def write_drive(folder: Path, steps: int, extra: str = "", rig: dict[str, object] | None = None) -> Path:
    """Write the round robot's drive: true poses, and in more columns its odometry."""
    robot = RoundRobot(steps)
    (folder / "images").mkdir(parents=True)
    pose, rows = Pose2(), []
    for k in range(steps):
        reading = robot.sense()
        assert reading is not None
        (folder / f"images/{k:03d}.png").write_bytes(reading.encoded)
        m = reading.motion
        if k:
            pose = pose @ Pose2(m.forward * math.cos(m.turn / 2), m.forward * math.sin(m.turn / 2), m.turn)
        more = f",{m.forward},{m.turn}" if extra else ""
        rows.append(f"{0.25 * k},{pose.x},{pose.y},{pose.heading},images/{k:03d}.png{more}")
    (folder / "drive.csv").write_text("\n".join([HEAD + extra, *rows]) + "\n")
    said = {"horizon_row": RIG.horizon_row, "camera_height": RIG.camera_height,
            "forward_column": RIG.forward_column, "clockwise": RIG.clockwise}  # fmt: skip
    (folder / "rig.json").write_text(json.dumps(said if rig is None else rig))
    return folder
