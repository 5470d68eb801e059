"""The panoramic camera: renders, bends, blurs, adds noise, encodes once and decodes what it encoded."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.column import Eye
from sim2d.config import CameraConfig
from sim2d.mirror import MirrorRig, mirror_image, sampled, tilt_map
from sim2d.records import CameraRig
from sim2d.render import add_noise, render
from sim2d.tones import tone_curves
from sim2d.world import World

NOISE_TABLE = 1 << 20
PROBE = 8  # automatic exposure looks at every so manieth column
GAINS = (0.05, 8.0)
EXPOSURE_TARGET = 110.0  # [grey levels] mean that automatic exposure aims at: a little under the middle of 0..255

Image = NDArray[np.uint8]


class Camera:
    """A cylindrical camera of W/(2 pi) pixels focal length; `rng` feeds its noise only.

    hour: the hour of the day [h] whose light it sees the world in, None for even light.
    """

    def __init__(self, config: CameraConfig, rng: np.random.Generator) -> None:
        self._config = config
        self._rng = rng
        self.hour = config.hour
        self.rig = CameraRig(
            width=config.width,
            height=config.height,
            horizon_row=(config.height - 1) / 2 if config.horizon_row is None else config.horizon_row,
            focal=config.width / math.tau,
            camera_height=config.camera_height,
            forward_column=config.forward_column,
            clockwise=config.clockwise,
        )
        tilted = config.roll_deg != 0 or config.pitch_deg != 0
        self._tilt = tilt_map(self.rig, math.radians(config.roll_deg), math.radians(config.pitch_deg))
        self._above = math.ceil(-float(self._tilt[1].min())) + 1 if tilted else None
        self._tones: tuple[tuple[float, float, float], NDArray[np.uint8]] | None = None
        # drawing fresh noise for every pixel would cost more than rendering it: a long table, entered anywhere
        table = np.rint(rng.normal(0.0, config.noise, NOISE_TABLE)) if config.noise > 0 else np.zeros(0)
        self._noise = np.clip(table, -127, 127).astype(np.int8)

    def view(self, world: World, x: float, y: float, heading: float) -> Image:
        """Return the panorama (H, W, 3) RGB at a pose [m, rad], without noise and codec."""
        if world.hour != self.hour:
            world.set_hour(self.hour)
        eye = self._eye(world, x, y, heading)
        if self._above is None:
            image = self._render(world, eye, self.rig.height, self.rig.width)
        else:
            rows = self._above + math.ceil(float(self._tilt[1].max())) + 2
            upright = self._render(world, eye._replace(horizon=float(self._above)), rows, self.rig.width)
            image = sampled(upright, self._tilt[0], self._tilt[1] + np.float32(self._above))
        return self._blurred(image) if self._config.blur > 0 else image

    def shoot(self, world: World, x: float, y: float, heading: float) -> tuple[Image, bytes]:
        """Return the decoded panorama (H, W, 3) RGB and the bytes it was decoded from, with noise."""
        image = self.view(world, x, y, heading)
        if len(self._noise):
            add_noise(image, self._noise, int(self._rng.integers(NOISE_TABLE)))
        encoded = self.encode(image)
        return decode(encoded), encoded

    def mirror_image(self, world: World, x: float, y: float, heading: float, mirror: MirrorRig) -> Image:
        """Return the raw image (mirror.height, mirror.width, 3) RGB of an omnidirectional mirror at a pose [m, rad]."""
        return mirror_image(self.view(world, x, y, heading), self.rig, mirror)

    def encode(self, image: Image) -> bytes:
        """Return an RGB image as the configured codec writes it."""
        options = {
            "jpeg": (".jpg", [cv2.IMWRITE_JPEG_QUALITY, self._config.quality]),
            "png": (".png", [cv2.IMWRITE_PNG_COMPRESSION, 1]),
        }
        suffix, flags = options[self._config.codec]
        return bytes(cv2.imencode(suffix, cv2.cvtColor(image, cv2.COLOR_RGB2BGR), flags)[1].tobytes())

    def _render(self, world: World, eye: Eye, rows: int, columns: int) -> Image:
        """Return what an eye sees, rightly exposed."""
        gain = self._config.gain
        if self._config.exposure == "auto":
            gain *= self._exposure(world, eye, rows, columns)
        image = np.empty((rows, columns, 3), dtype=np.uint8)
        render(world.scene(), world.atlas, eye, world.daylight.glow, self._curves(world, gain), image)
        return image

    def _exposure(self, world: World, eye: Eye, rows: int, columns: int) -> float:
        """Return the gain at which the view's mean comes to the target, from a dark look at a few columns."""
        probe = np.empty((rows, max(1, columns // PROBE), 3), dtype=np.uint8)
        few = eye._replace(turn=eye.turn * PROBE, forward_column=eye.forward_column // PROBE)
        # a quarter of the light, so that hardly anything is cut at white
        curves = tone_curves(0.25 * world.daylight.gain, world.daylight.tint)
        render(world.scene(), world.atlas, few, world.daylight.glow, curves, probe)
        gain = 0.25 * EXPOSURE_TARGET / max(float(probe.mean()), 0.5)
        return min(max(gain, GAINS[0]), GAINS[1])

    def _curves(self, world: World, gain: float) -> NDArray[np.uint8]:
        """Return the tone curves for a gain in the world's present light; the last ones are kept."""
        key = (gain, world.daylight.gain, sum(world.daylight.tint))
        if self._tones is None or self._tones[0] != key:
            self._tones = (key, tone_curves(gain * world.daylight.gain, world.daylight.tint))
        return self._tones[1]

    def _blurred(self, image: Image) -> Image:
        """Return an image blurred round the ring."""
        pad = min(image.shape[1], math.ceil(4 * self._config.blur))
        ring = np.concatenate([image[:, -pad:], image, image[:, :pad]], axis=1)
        soft = cv2.GaussianBlur(ring, (0, 0), self._config.blur, borderType=cv2.BORDER_REPLICATE)
        return np.ascontiguousarray(soft[:, pad : pad + image.shape[1]], dtype=np.uint8)

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


def decode(encoded: bytes) -> Image:
    """Return the RGB image (H, W, 3) of JPEG or PNG bytes. Raises ValueError for others."""
    image = cv2.imdecode(np.frombuffer(encoded, dtype=np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError("these bytes are no JPEG or PNG image")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
