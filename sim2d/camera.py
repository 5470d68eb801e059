"""The panoramic camera: renders, adds noise, encodes once and decodes what it encoded."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.column import Eye
from sim2d.config import CameraConfig
from sim2d.lights import even
from sim2d.records import CameraRig
from sim2d.render import add_noise, render
from sim2d.tones import tone_curves
from sim2d.world import World

NOISE_TABLE = 1 << 20


class Camera:
    """A cylindrical camera of W/(2 pi) pixels focal length; `rng` feeds its noise only."""

    def __init__(self, config: CameraConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._rng = rng
        self.rig = CameraRig(
            width=config.width,
            height=config.height,
            horizon_row=(config.height - 1) / 2,
            focal=config.width / math.tau,
            camera_height=config.camera_height,
            forward_column=config.forward_column,
            clockwise=config.clockwise,
        )
        self._tones = tone_curves(config.gain)
        # drawing fresh noise for every pixel would cost more than rendering it: a long table, entered anywhere
        table = np.rint(rng.normal(0.0, config.noise, NOISE_TABLE)) if config.noise > 0 else np.zeros(0)
        self._noise = np.clip(table, -127, 127).astype(np.int8)

    def view(self, world: World, x: float, y: float, heading: float) -> NDArray[np.uint8]:
        """Return the panorama (H, W, 3) RGB at a pose [m, rad], without noise and codec."""
        image = np.empty((self.rig.height, self.rig.width, 3), dtype=np.uint8)
        render(world.scene(), world.atlas, self._eye(world, x, y, heading), even(), self._tones, image)
        return image

    def shoot(self, world: World, x: float, y: float, heading: float) -> tuple[NDArray[np.uint8], bytes]:
        """Return the decoded panorama (H, W, 3) RGB and the bytes it was decoded from, with noise."""
        image = self.view(world, x, y, heading)
        if len(self._noise):
            add_noise(image, self._noise, int(self._rng.integers(NOISE_TABLE)))
        encoded = self.encode(image)
        return decode(encoded), encoded

    def encode(self, image: NDArray[np.uint8]) -> bytes:
        """Return an RGB image as the configured codec writes it."""
        options = {
            "jpeg": (".jpg", [cv2.IMWRITE_JPEG_QUALITY, self._config.quality]),
            "png": (".png", [cv2.IMWRITE_PNG_COMPRESSION, 1]),
        }
        suffix, flags = options[self._config.codec]
        return bytes(cv2.imencode(suffix, cv2.cvtColor(image, cv2.COLOR_RGB2BGR), flags)[1].tobytes())

    def _eye(self, world: World, x: float, y: float, heading: float) -> Eye:
        turn = math.tau / self.rig.width
        return Eye(
            float(x),
            float(y),
            float(heading),
            self.rig.camera_height,
            self.rig.focal,
            self.rig.horizon_row,
            self.rig.forward_column,
            -turn if self.rig.clockwise else turn,
            world.spec.ceiling_height,
            world.floor,
            world.ceiling,
            world.spec.floor.gloss,
        )


def decode(encoded: bytes) -> NDArray[np.uint8]:
    """Return the RGB image (H, W, 3) of JPEG or PNG bytes. Raises ValueError for others."""
    image = cv2.imdecode(np.frombuffer(encoded, dtype=np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError("these bytes are no JPEG or PNG image")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
