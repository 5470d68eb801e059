"""A robot of one's own: two laps through a round room with striped walls; its log replays to the same map."""

import numpy as np

import topomap

RIG = topomap.Rig.cylinder(width=180, height=40, camera_height=0.5)
WALL = np.random.default_rng(1).integers(40, 220, (360, 3), dtype=np.uint8)  # a colour a degree, 3 m off the middle
MOTION = topomap.Motion(0.157, 0.0, np.radians(6), np.diag([1e-4, 1e-6, 1e-5]), dt=1.0)  # 60 to a circle of 1.5 m


class OwnRobot:
    step = -1

    def sense(self):
        self.step, heading = self.step + 1, np.radians(6 * self.step + 6)
        place = 1.5 * np.exp(1j * (heading - np.pi / 2))
        rays = np.exp(1j * (heading + (RIG.forward_column - np.arange(180)) * np.pi / 90))  # a column, clockwise
        far = np.sqrt((place.conj() * rays).real ** 2 + 3.0**2 - 1.5**2) - (place.conj() * rays).real
        wall = np.arange(40)[:, None] - RIG.horizon_row < RIG.focal * 0.5 / far  # above the floor's edge
        view = np.where(wall[..., None], WALL[np.degrees(np.angle(place + far * rays)).astype(int)], np.uint8(90))
        return topomap.Reading(stamp_ns=self.step * 10**9, image=view, motion=MOTION, rig=RIG, driven=self.step < 130)

    def act(self, command): ...  # its owner pushes it round ...
    def stop(self): ...  # ... and holds it


if __name__ == "__main__":
    run = topomap.drive(OwnRobot(), out="runs/own-robot", settings=["stack.mission.then=stop"], force=True)
    print(run.summary["graph_hash"], topomap.replay("runs/own-robot/run.mcap").summary["graph_hash"])
