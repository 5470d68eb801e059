"""The panoramic camera: renders, bends, blurs, adds noise, encodes once and decodes what it encoded."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.config import CameraConfig
from sim2d.records import CameraRig
from sim2d.render.column import Eye
from sim2d.render.panorama import add_noise, render
from sim2d.render.tones import tone_curves
from sim2d.sensors.exposure import Exposure
from sim2d.sensors.lens import transmission
from sim2d.sensors.mirror import MirrorRig, Tilt, mirror_image, sampled
from sim2d.sensors.shutter import Pose, blended, moments
from sim2d.sensors.sway import Sway
from sim2d.shapes import Colour
from sim2d.world import World

NOISE_TABLE = 1 << 20
PROBE = 8  # automatic exposure looks at every so manieth column
DARK = 0.25  # of the light is let in for that, so that hardly anything is cut at white

Image = NDArray[np.uint8]


class Camera:
    """A cylindrical camera of W/(2 pi) pixels focal length; `rng` feeds its noise only.

    body: feeds what is drawn once, the lenses' colours and the floor's bumps. gloss: what the floor mirrors, the
    world's own where it is None. hour: the hour of the day [h] whose light it sees the world in, None for even light.
    """

    def __init__(
        self,
        config: CameraConfig,
        rng: np.random.Generator,
        body: np.random.Generator | None = None,
        gloss: float | None = None,
    ) -> None:
        self._config = config
        self._rng = rng
        self._gloss = gloss
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
        body = np.random.default_rng(0) if body is None else body
        self._transmission = transmission(self.rig, config.lens, body)
        self._sway = Sway(config.sway, body)
        self._exposure = Exposure(config)
        self._mount = Tilt.of(self.rig, math.radians(config.roll_deg), math.radians(config.pitch_deg))
        self._tones: tuple[tuple[float, ...], NDArray[np.uint8]] | None = None
        # drawing fresh noise for every pixel would cost more than rendering it: a long table, entered anywhere
        table = np.rint(rng.normal(0.0, config.noise, NOISE_TABLE)) if config.noise > 0 else np.zeros(0)
        self._noise = np.clip(table, -127, 127).astype(np.int8)

    def view(self, world: World, x: float, y: float, heading: float) -> Image:
        """Return the panorama (H, W, 3) RGB at a pose [m, rad], at rest, without noise and codec."""
        self._light(world)
        pose = (x, y, heading)
        return self._developed(self._exposed(world, pose, self._mount, *self._asked(world, pose)))

    def shoot(
        self, world: World, x: float, y: float, heading: float, before: Pose | None = None, dt: float = 0.0
    ) -> tuple[Image, bytes]:
        """Return the decoded panorama (H, W, 3) RGB and the bytes it was decoded from, with noise.

        before: the pose dt [s] earlier, from which shutter, sway and the lag of the exposure follow; None: at rest.
        """
        self._light(world)
        pose = (x, y, heading)
        before = pose if before is None else before
        tilt = self._leaning(pose, before, dt)
        gain, balance = self._exposure.follow(*self._asked(world, pose), dt)
        shutter = self._config.shutter
        poses, weights = moments(shutter, self.rig.height, self.rig.focal, pose, before, dt)
        image = self._developed(blended([self._exposed(world, p, tilt, gain, balance) for p in poses], weights))
        if len(self._noise):
            add_noise(image, self._noise, int(self._rng.integers(NOISE_TABLE)))
        encoded = self.encode(image)
        return decode(encoded), encoded

    def mirror_image(self, world: World, x: float, y: float, heading: float, mirror: MirrorRig) -> Image:
        """Return the raw image (mirror.height, mirror.width, 3) RGB of an omnidirectional mirror at a pose [m, rad]."""
        return mirror_image(self.view(world, x, y, heading), self.rig, mirror)

    def encode(self, image: Image) -> bytes:
        """Return an RGB image as the configured codec writes it, a JPEG within its greatest size where that can be."""
        if self._config.codec == "png":
            return _encoded(image, ".png", [cv2.IMWRITE_PNG_COMPRESSION, 1])
        encoded = _jpeg(image, self._config.quality)
        if self._config.max_bytes is None or len(encoded) <= self._config.max_bytes:
            return encoded
        # the greatest quality whose picture fits, by halving
        least, most = 1, self._config.quality
        while most - least > 1:
            middle = (least + most) // 2
            fits = len(_jpeg(image, middle)) <= self._config.max_bytes
            least, most = (middle, most) if fits else (least, middle)
        return _jpeg(image, least)

    def _light(self, world: World) -> None:
        if world.hour != self.hour:
            world.set_hour(self.hour)

    def _leaning(self, pose: Pose, before: Pose, dt: float) -> Tilt:
        """Return the mount's tilt and the body's lean together."""
        if not self._sway.moves:
            return self._mount
        speed = math.hypot(pose[0] - before[0], pose[1] - before[1]) / dt if dt > 0 else 0.0
        rate = math.remainder(pose[2] - before[2], math.tau) / dt if dt > 0 else 0.0
        roll, pitch = self._sway.lean(pose[0], pose[1], speed, rate, dt)
        mount = self._config
        return Tilt.of(self.rig, math.radians(mount.roll_deg) + roll, math.radians(mount.pitch_deg) + pitch)

    def _exposed(self, world: World, pose: Pose, tilt: Tilt, gain: float, balance: Colour) -> Image:
        """Return the picture at a pose, by the gain and channel gains."""
        eye = self._eye(world, *pose)
        curves = self._curves(world, gain * self._config.gain, balance)
        if tilt.maps is None:
            return self._render(world, eye, self.rig.height, self.rig.width, curves)
        columns, rows = tilt.maps
        above = math.ceil(-float(rows.min())) + 1
        height = above + math.ceil(float(rows.max())) + 2
        upright = self._render(world, eye._replace(horizon=float(above)), height, self.rig.width, curves)
        return sampled(upright, columns, rows + np.float32(above))

    def _developed(self, image: Image) -> Image:
        """Return what the optics make of a picture."""
        if self._transmission is not None:
            image = np.rint(np.minimum(image * self._transmission, 255.0)).astype(np.uint8)
        return self._blurred(image) if self._config.blur > 0 else image

    def _render(self, world: World, eye: Eye, rows: int, columns: int, curves: NDArray[np.uint8]) -> Image:
        image = np.empty((rows, columns, 3), dtype=np.uint8)
        render(world.scene(), world.atlas, eye, world.daylight.glow, curves, image)
        return image

    def _asked(self, world: World, pose: Pose) -> tuple[float, Colour]:
        """Return the gain and channel gains that the view asks for, by a dark look at a few columns."""
        if not self._exposure.looks:
            return 1.0, (1.0, 1.0, 1.0)
        eye = self._eye(world, *pose)
        few = eye._replace(turn=eye.turn * PROBE, forward_column=eye.forward_column // PROBE)
        curves = tone_curves(DARK * world.daylight.gain, world.daylight.tint)
        probe = self._render(world, few, self.rig.height, max(1, self.rig.width // PROBE), curves)
        return self._exposure.asked(probe, DARK)

    def _curves(self, world: World, gain: float, balance: Colour) -> NDArray[np.uint8]:
        """Return the tone curves for gains in the world's present light; the last ones are kept."""
        r, g, b = (light * own for light, own in zip(world.daylight.tint, balance, strict=True))
        key = (gain * world.daylight.gain, r, g, b)
        if self._tones is None or self._tones[0] != key:
            self._tones = (key, tone_curves(key[0], (r, g, b)))
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
            world.spec.floor.gloss if self._gloss is None else self._gloss,
        )


def _jpeg(image: Image, quality: int) -> bytes:
    return _encoded(image, ".jpg", [cv2.IMWRITE_JPEG_QUALITY, quality])


def _encoded(image: Image, suffix: str, flags: list[int]) -> bytes:
    return bytes(cv2.imencode(suffix, cv2.cvtColor(image, cv2.COLOR_RGB2BGR), flags)[1].tobytes())


def decode(encoded: bytes) -> Image:
    """Return the RGB image (H, W, 3) of JPEG or PNG bytes. Raises ValueError for others."""
    image = cv2.imdecode(np.frombuffer(encoded, dtype=np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError("these bytes are no JPEG or PNG image")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
