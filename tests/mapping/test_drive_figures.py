"""A lap and a half of a round room with an odometer that errs: what each stage of mapping makes of it is as before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, replace
from functools import cache

import numpy as np
import pytest
from kept import as_before, of_drive
from round_world import LAP, RoundRobot

from topomap import Reading
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator
from topomap.core.panorama import Panorama
from topomap.core.records import StepRecord
from topomap.mapping.closures.difference_rule import DifferenceRule, DifferenceRuleSettings
from topomap.mapping.closures.relative_pose import RelativePoseSettings
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.odometry.watch import OdometryWatch
from topomap.mapping.places.place_groups import group_places
from topomap.mapping.sessions.condense import condense
from topomap.mapping.sessions.cross_claims import CrossClaims
from topomap.mapping.sessions.merge import merge
from topomap.mapping.sessions.prune import prune
from topomap.vision.registry import aligner

STEPS = LAP + 45


@cache
def readings() -> list[Reading]:
    """What the robot senses; its turns read too large, increments, images and ranges are noisy."""
    robot, rng, found = RoundRobot(STEPS + 5), np.random.default_rng(11), []
    for _ in range(STEPS):
        reading = robot.sense()
        assert reading is not None
        way, aside, turn = rng.normal(size=3) * [0.004, 0.001, 0.003]
        motion = reading.motion
        read = replace(motion, forward=0.97 * motion.forward + way, left=aside, turn=1.03 * motion.turn + turn)
        image = np.clip(reading.image + rng.normal(0.0, 12.0, reading.image.shape), 0, 255).astype(np.uint8)
        assert reading.ranges is not None
        ranges = (reading.ranges + rng.normal(0.0, 0.02, reading.ranges.shape)).astype(np.float32)
        found.append(replace(reading, motion=read, image=image, encoded=b"", ranges=ranges, driven=True, quality=None))
    return found


def driven(ranges: bool) -> tuple[Mapper, list[StepRecord]]:
    navigator, records = build_navigator(load_config().stack), []
    for reading in readings():
        own = reading if ranges else replace(reading, ranges=None, quality=None)
        records.append(navigator.step(own)[1])
    navigator.mapper.finish(records[-1].stamp_ns)
    return navigator.mapper, records


@pytest.fixture(scope="module")
def drives() -> dict[bool, tuple[Mapper, list[StepRecord]]]:
    return {ranges: driven(ranges) for ranges in (True, False)}


def told(topo: TopoMap) -> dict[str, object]:
    edges = topo.closures
    return {
        "nodes": topo.poses[::2],
        "travel": [node.travel for node in topo.nodes[::2]],
        "closures": [(edge.i, edge.j) for edge in edges],
        "relative": [edge.relative.array() for edge in edges],
        "spread": [np.sqrt(np.diag(edge.covariance)) for edge in edges],
        "calibration": topo.calibration.vector(),
        "turns": [(edge.i, edge.j, edge.turn, edge.sigma) for edge in topo.turns[::2]],
    }


@pytest.mark.parametrize("ranges", [True, False])
def test_a_drive_is_as_before(drives: dict[bool, tuple[Mapper, list[StepRecord]]], ranges: bool) -> None:
    mapper, records = drives[ranges]
    optimisation = mapper.optimisation
    scale, noise = optimisation.sequential.distance_scale, mapper.map.noise
    found = {**of_drive(records, 3), **{f"map {said}": one for said, one in told(mapper.map).items()}}
    found |= {
        "covariance": np.sqrt(np.abs(optimisation.covariance)) * 10,
        "scale": [scale.value, scale.sigma, scale.observed],
        "noise": [noise.forward or 0.0, noise.turn or 0.0],
        "catchment": [mapper.recognition.catchment.length, mapper.recognition.catchment.other],
        "limit": [mapper.recognition.limit, mapper.recognition.far],
        "contrast": [mapper.recognition.contrast.log_ratio(d, 1.0) for d in (0.1, 0.3, 0.5)],
        "contest": [optimisation.trust.kept],
        "solves": [optimisation.solves],
    }
    # without ranges an offset is where a flat difference is least
    close, floor = (1e-4, 0.0) if ranges else (0.01, 1e-3)
    as_before(f"round drive {'with' if ranges else 'without'} ranges", found, close=close, floor=floor)


def test_what_is_made_of_a_map_is_as_before(drives: dict[bool, tuple[Mapper, list[StepRecord]]]) -> None:
    first, second = drives[True][0].map, drives[False][0].map
    joined = merge(first, second, CrossClaims(aligner("min-warping"), RelativePoseSettings()), lambda share, what: None)
    pruned = prune(first)
    groups = group_places(first)
    counts = [joined.offset, joined.proposed, joined.across, joined.lost]
    as_before("merged", {**told(joined.map), "counts": counts}, close=0.01, floor=1e-3)
    as_before("pruned", {**told(pruned.map), "gone": pruned.gone})
    as_before("groups", {"nodes": [one for group in groups.members for one in (len(group), *group)]})
    condense(joined.map)
    as_before("condensed", {"ways": [way.deltas.sum(axis=0) for _, _, way in joined.map.odometry_edges()],
                            "spread": [np.sqrt(way.covariances[0].diagonal()) * 10
                                       for _, _, way in joined.map.odometry_edges()]})  # fmt: skip


def test_the_thesis_own_rule_is_as_before() -> None:
    rule, closed = DifferenceRule(DifferenceRuleSettings(threshold=1.5, travel=6.0)), []
    for reading in readings():
        closure = rule.advance(Panorama.from_reading(reading), reading.motion)
        if closure is not None:
            closed.append(
                [closure.now, closure.old, closure.rotation, closure.difference, closure.k_theta, closure.k_d]
            )
    as_before("difference rule", {"closed": closed, "path": rule.path[::5], "kept": rule.kept})


def spoilt() -> dict[str, Callable[[int, Reading], Reading]]:
    """What odometry and senses do wrong, from step 40 on and for a while."""

    def moved(**times: float) -> Callable[[int, Reading], Reading]:
        def change(k: int, reading: Reading) -> Reading:
            motion = reading.motion
            forward = motion.forward * times.get("way", 1.0) + times.get("leap", 0.0)
            turn = motion.turn * times.get("turn", 1.0) + times.get("more", 0.0)
            wrong = replace(reading, motion=replace(motion, forward=forward, turn=turn), quality=None)
            return wrong if 40 <= k < 40 + times.get("steps", 12) else reading

        return change

    still = readings()[39].image
    return {
        "well": lambda k, reading: reading,
        "slip": moved(way=2.5),
        "dead": moved(way=0.0, turn=0.0),
        "one wheel": moved(way=0.5, more=0.25),
        "reset": moved(leap=-6.0, more=1.0, steps=1),
        "blind": lambda k, reading: replace(moved(way=0.0, turn=0.0)(k, reading), ranges=None, quality=None),
        "spun": lambda k, r: replace(r, image=still, ranges=None, encoded=b"", quality=None) if 40 <= k < 48 else r,
    }


@pytest.mark.parametrize("name", spoilt())
def test_what_is_said_of_odometry_is_as_before(name: str) -> None:
    watch, told, words, change = OdometryWatch(), [], [], spoilt()[name]
    for k, whole in enumerate(readings()[:70]):
        reading = change(k, whole)
        broken = watch.judge(Panorama.from_reading(reading), reading.motion, Calibration(1.03, 0.0, 0.97))
        words += [f"{k}: {word}" for word in (broken, watch.said) if word]
        if watch.seen is not None:
            told.append([k, *(-1.0 if one is None else one for one in astuple(watch.seen))])
        told.append([k, watch.doubted, watch.turned])
    as_before("odometry watched", {name: [one for row in told for one in row], f"{name}, said": words}, part=True)
