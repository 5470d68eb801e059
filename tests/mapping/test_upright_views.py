"""A drive whose camera leans: what was kept before that was known is taken upright too, and a map keeps it."""

from __future__ import annotations

import json
import math
import zipfile
from dataclasses import replace
from functools import cache
from io import BytesIO

import numpy as np
import pytest
from maps import square

from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.core.panorama import Panorama
from topomap.core.records import Command
from topomap.core.robot import Reading
from topomap.core.view_size import parse_view
from topomap.mapping.mapfile import from_bytes, to_bytes
from topomap.mapping.mapper import Mapper, MapperSettings
from topomap.mapping.places.small_view import view_of
from topomap.mapping.places.upright_views import UprightViews
from topomap.vision.image.compare import signature
from topomap.vision.registry import aligner

STEPS = 14


@cache
def readings(roll: float) -> tuple[Reading, ...]:
    """The first readings of a drive whose camera leans to the right [degrees]."""
    config = load_config(None, (f"sim.camera.roll_deg={roll}",))
    robot = SimRobot(worlds.load("room-corridor"), config.sim, 3)
    made = []
    for _ in range(STEPS):
        reading = robot.sense()
        assert reading is not None
        made.append(reading)
        robot.act(Command())
    return tuple(made)


def mapped(roll: float, view: str = "full") -> tuple[Mapper, list[str]]:
    settings = MapperSettings()
    settings = settings.model_copy(update={"snapshots": settings.snapshots.model_copy(update={"view": view})})
    mapper, said = Mapper(settings, aligner("min-warping")), []
    for reading in readings(roll):
        mapper.update(reading, mapper.seen(Panorama.from_reading(reading), reading.motion.turn))
        said.append(mapper.restated_camera)
    return mapper, said


@pytest.mark.parametrize("view", ["full", "90x12x4"])
def test_views_kept_before_the_lean_was_known_are_taken_upright(view: str) -> None:
    mapper, said = mapped(3.0, view)
    assert sum(map(bool, said)) == 1
    assert "leans 2." in "".join(said) or "leans 3." in "".join(said)
    first, last = (node.snapshot for node in (mapper.map.nodes[0], mapper.map.nodes[-1]))
    assert first is not None
    assert last is not None
    assert math.degrees(first.rig.roll) == pytest.approx(3.0, abs=0.6)
    if view == "full":
        assert last.rig.roll == first.rig.roll
    straight, _ = mapped(0.0, view)
    leaning = view_of(replace(first, rig=replace(first.rig, roll=0.0, pitch=0.0)), parse_view(view))
    known, kept = straight.view_cache.panorama(0), mapper.view_cache.panorama(0)
    off, before = (np.abs(p.image.astype(float) - known.image).mean() for p in (kept, leaning))
    assert off < 0.75 * before
    found = mapper.recognition.index.compare(signature(kept), np.array([0])).difference[0]
    assert found < 1e-3, "place search has it as the map has it"


def test_a_map_keeps_how_its_camera_leant() -> None:
    mapper, _ = mapped(3.0)
    loaded = from_bytes(to_bytes(mapper.map))
    assert to_bytes(loaded) == to_bytes(mapper.map)
    assert _format(to_bytes(mapper.map)) == 4
    first = loaded.nodes[0].snapshot
    assert first is not None
    assert np.array_equal(view_of(first, None).image, mapper.view_cache.panorama(0).image)


def test_a_drive_on_a_map_begins_with_how_its_camera_leant() -> None:
    mapper, _ = mapped(3.0)
    first = mapper.map.nodes[0].snapshot
    assert first is not None
    again = UprightViews(from_bytes(to_bytes(mapper.map)))
    raw = Panorama.from_reading(readings(3.0)[0])
    assert np.array_equal(again.see(raw, 0.0).image, view_of(first, None).image)
    other = UprightViews(mapper.map)
    for _ in range(4):  # another camera, which stands upright
        for reading in readings(0.0):
            seen = other.see(Panorama.from_reading(reading), 0.0)
    assert np.array_equal(seen.image, Panorama.from_reading(readings(0.0)[-1]).image)


def test_an_upright_cameras_map_is_written_as_before() -> None:
    mapper, said = mapped(0.0)
    assert not any(said)
    assert _format(to_bytes(mapper.map)) == 3
    assert b'"roll"' not in _meta(to_bytes(mapper.map))


def test_a_pose_node_has_no_camera() -> None:
    topo = square()
    topo.nodes[2] = replace(topo.nodes[2], snapshot=None)
    with pytest.raises(ValueError, match="node 2 is a pose node"):
        topo.restate(2, 0.1, 0.0, ())


def _meta(data: bytes) -> bytes:
    with zipfile.ZipFile(BytesIO(data)) as archive:
        return bytes(np.load(BytesIO(archive.read("meta.npy"))).tobytes())


def _format(data: bytes) -> int:
    return int(json.loads(_meta(data))["format"])


@cache
def behind_bars() -> tuple[Reading, ...]:
    """A drive round three corners with a mirror that bars hold."""
    config = load_config(None, ("sim.camera.lens={lenses=2,supports=3,support_deg=8}", "sim.driver.laps=1"))
    robot = SimRobot(worlds.load("room-corridor"), config.sim, 3)
    return tuple(r for _ in range(160) if (r := robot.sense()) is not None)


@pytest.mark.parametrize("view", ["full", "90x12x4"])
def test_views_kept_before_the_bars_were_known_are_filled_and_a_map_keeps_it(view: str) -> None:
    settings = MapperSettings()
    settings = settings.model_copy(update={"snapshots": settings.snapshots.model_copy(update={"view": view})})
    mapper, said = Mapper(settings, aligner("min-warping")), []
    for reading in behind_bars():
        mapper.update(reading, mapper.seen(Panorama.from_reading(reading), reading.motion.turn))
        said += [mapper.restated_camera] if "hides" in mapper.restated_camera else []
    assert said[0].startswith("the robot hides 3 parts of its view, 2")
    data = to_bytes(mapper.map)
    assert _format(data) == 5
    loaded = from_bytes(data)
    assert to_bytes(loaded) == data
    first = loaded.nodes[0].snapshot
    assert first is not None
    assert len(first.rig.hidden) == 3
    assert _bars(view_of(replace(first, rig=replace(first.rig, hidden=())), parse_view(view))) >= 3, "as it was taken"
    assert _bars(mapper.view_cache.panorama(0)) == 0
    assert np.array_equal(view_of(first, parse_view(view)).image, mapper.view_cache.panorama(0).image)
    assert _bars(UprightViews(loaded).see(Panorama.from_reading(behind_bars()[0]), 0.0)) == 0


def _bars(view: Panorama) -> int:
    """Columns that are dark from top to bottom."""
    return int((view.image.max(axis=(0, 2)) < 40).sum())
