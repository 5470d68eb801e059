"""The panorama's pixels: columns are rays, rows follow from true heights on the cylinder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim2d.render.atlas import Atlas
from sim2d.render.column import FADE, Eye, Ground, mirror_rows, paint_ceiling, paint_floor, paint_lid, paint_wall
from sim2d.render.kernel import kernel
from sim2d.render.lights import Glow, glow_on
from sim2d.render.raycast import BACK, MAX_HITS, FloatArray, IntArray, walk
from sim2d.render.scene import CIRCLE, SEGMENT, Scene
from sim2d.render.texel import ONE, level_at

FAR = 200.0  # [m] nothing is drawn beyond


@kernel
def _skin(
    scene: Scene, atlas: Atlas, s: int, eye: Eye, glow: Glow, dx: float, dy: float, t: float, skin: FloatArray
) -> None:
    """Write what painting a surface hit at t [m] needs: entries of its two texel columns, weight, texels along v,
    texels per metre along v, brightness, top [m]."""
    px, py = eye.x + t * dx, eye.y + t * dy
    if scene.kind[s] == CIRCLE:
        nx, ny = (px - scene.line[s, 0]) / scene.line[s, 2], (py - scene.line[s, 1]) / scene.line[s, 2]
        u = scene.along[s] + np.arctan2(ny, nx) * scene.line[s, 2]
        light = 0.86 + 0.1 * nx + 0.06 * ny
    else:
        ax, ay = scene.line[s, 0], scene.line[s, 1]
        ex, ey = scene.line[s, 2] - ax, scene.line[s, 3] - ay
        length = np.hypot(ex, ey)
        u = scene.along[s] + ((px - ax) * ex + (py - ay) * ey) / length
        nx, ny, light = ey / length, -ex / length, scene.light[s]
    if glow.lit:
        light = glow_on(glow, px, py, nx, ny, dx, dy)
    tile = scene.tile[s]
    level = level_at(t / eye.focal / np.sqrt(max(0.05, abs(nx * dx + ny * dy))))
    nu, nv, base = atlas.nu[tile, level], atlas.nv[tile, level], atlas.offset[tile, level]
    fu = u / atlas.size[tile, 0] * nu - 0.5
    i = int(np.floor(fu))
    skin[2] = int((fu - i) * 64)
    i %= nu
    k = i + 1 if i + 1 < nu else 0
    skin[0], skin[1] = base + i * nv, base + k * nv
    skin[3], skin[4] = nv, nv / atlas.size[tile, 1]
    skin[5], skin[6] = light / (1 + t / FADE), scene.top[s]


@kernel
def _exit(solid: IntArray, hits: FloatArray, surfaces: IntArray, sides: IntArray, k: int, n: int) -> float:
    """Return where the ray leaves the solid that it entered at hit k."""
    for m in range(k + 1, n):
        if sides[m] == BACK and solid[surfaces[m]] == solid[surfaces[k]]:
            return float(hits[m])
    return float(hits[k])


@kernel
def _rows(atlas: Atlas, eye: Eye, tile: int, rise: float, height: int, gloss: float, mirrored: bool) -> Ground:
    """Return the rows of a floor or ceiling `rise` [m] from the eye; gloss: how far the floor there mirrors."""
    reach, whole = np.empty(height), np.empty((4, height), np.int64)
    for r in range(height):
        t = min(FAR, rise * eye.focal / max(abs(r - eye.horizon), 1e-3))
        # a ground pixel is longer than wide: the geometric mean of both decides
        level = level_at(t / eye.focal * np.sqrt(max(1.0, t / rise)))
        fade = 1 / (1 + t / FADE)
        # stone mirrors more at a flatter angle
        seen = min(FAR, eye.height * eye.focal / max(abs(r - eye.horizon), 1e-3))
        share = gloss * (0.3 + 0.7 * seen / (seen + 2.0))
        reach[r], whole[0, r] = t, int(fade * (1 - share) * ONE)
        whole[1, r] = int(share * (fade if mirrored else 1.0) * ONE)  # a mirrored wall brings its own fading
        whole[2, r], whole[3, r] = atlas.offset[tile, level], atlas.nu[tile, level]
    return Ground(reach, whole[0], whole[1], whole[2], whole[3], 1 / atlas.size[tile, 0])


@kernel
def render(
    scene: Scene, atlas: Atlas, eye: Eye, glow: Glow, tones: NDArray[np.uint8], image: NDArray[np.uint8]
) -> None:
    """Fill image (H, W, 3) RGB with what the camera sees, without noise; tones (3 x 4096,) as in `texel.put`."""
    height, width = image.shape[:2]
    texels, pixels = atlas.texels, image.reshape(-1)
    hits, skins = np.empty(MAX_HITS), np.empty((MAX_HITS, 8))
    surfaces, sides = np.empty(MAX_HITS, np.int64), np.empty(MAX_HITS, np.int64)
    mixed = np.empty(np.max(atlas.nv) + 2, np.uint64)
    floor = _rows(atlas, eye, eye.floor, eye.height, height, eye.gloss, False)
    ceiling = _rows(atlas, eye, eye.ceiling, eye.room - eye.height, height, 0.0, False)
    mirror = _rows(atlas, eye, eye.ceiling, eye.room + eye.height, height, eye.gloss, True)
    for c in range(width):
        angle = eye.heading + (c - eye.forward_column) * eye.turn
        dx, dy = np.cos(angle), np.sin(angle)
        n = walk(scene, eye.x, eye.y, dx, dy, FAR, eye.room, hits, surfaces, sides)
        for k in range(n):
            if sides[k] != BACK:
                _skin(scene, atlas, surfaces[k], eye, glow, dx, dy, hits[k], skins[k])
        mirror_rows(hits, sides, skins, n, eye)
        y = height - 1  # what is seen fills the column from its foot upwards
        for k in range(n + 1):
            if k < n and sides[k] == BACK:
                continue
            foot = eye.horizon + (eye.focal * eye.height / hits[k] if k < n else 0.0)
            y = paint_floor(
                texels, tones, pixels, width, c, y, foot, eye, glow, floor, mirror, dx, dy, hits, skins, k, n
            )
            if k == n:
                break
            y = paint_wall(texels, tones, pixels, width, c, y, skins[k], hits[k], eye, mixed)
            if y >= 0 and skins[k, 6] < eye.height and scene.kind[surfaces[k]] != SEGMENT:
                far = _exit(scene.solid, hits, surfaces, sides, k, n)
                y = paint_lid(scene, atlas, tones, pixels, width, c, y, surfaces[k], far, eye, glow, dx, dy)
        paint_ceiling(texels, tones, pixels, width, c, y, eye, glow, ceiling, dx, dy)


@kernel
def add_noise(image: NDArray[np.uint8], noise: NDArray[np.int8], start: int) -> None:
    """Add entries of a long noise table, from `start` on, to all pixels in place."""
    flat = image.reshape(-1)
    size = len(noise)
    k = start
    for i in range(len(flat)):
        value = np.int64(flat[i]) + noise[k]
        flat[i] = np.uint8(min(255, max(0, value)))
        k += 1
        if k == size:
            k = 0
