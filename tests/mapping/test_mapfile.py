"""The map file: loads back equal, or says in one line what is wrong."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tracemalloc
import zipfile
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from maps import RIG, STEP_NS, snapshot, square

from topomap.core.errors import DataError
from topomap.mapping.graph import Node
from topomap.mapping.mapfile import from_bytes, load_map, save_map, to_bytes
from topomap.mapping.odometry.increments import Calibration, Increments
from topomap.mapping.optimizer import TurnEdge


def test_a_map_loads_back_equal(tmp_path: Path) -> None:
    topo = square()
    topo.insert(7 * STEP_NS)
    topo.calibration = Calibration(1.04, 0.003, 0.95)
    topo.turns += [TurnEdge(0, 1, 0.1, 0.01), TurnEdge(1, 2, -1 / 3, 1 / 7)]
    save_map(topo, tmp_path / "a.topomap")
    loaded = load_map(tmp_path / "a.topomap")
    assert loaded.hash([]) == topo.hash([])
    assert loaded.calibration == topo.calibration
    assert to_bytes(loaded) == to_bytes(topo)
    assert loaded.turns == topo.turns
    assert sorted(loaded.graph.edges) == sorted(topo.graph.edges)
    assert loaded.trajectory()[1].tolist() == topo.trajectory()[1].tolist()
    first, second = loaded.nodes[3].snapshot, topo.nodes[3].snapshot
    assert first is not None
    assert second is not None
    assert first.rig == second.rig
    assert first.ranges is not None
    assert first.ranges.tolist() == [3.0] * 72


def test_a_map_of_the_first_format_loads_without_turns() -> None:
    topo = square()
    topo.turns.append(TurnEdge(0, 1, 0.1, 0.01))
    loaded = from_bytes(first_format(to_bytes(topo)))
    assert loaded.hash([]) == topo.hash([])
    assert loaded.turns == []


def first_format(data: bytes, number: int = 1) -> bytes:
    """The bytes as the first house wrote them: another number, no turns, no numbers, ranges row by row."""
    with np.load(io.BytesIO(data)) as file:
        arrays = {name: file[name] for name in file.files if not name.startswith(("turn", "names", "jumps"))}
    arrays["ranges"] = arrays["ranges"].reshape(-1, RIG.width)
    meta = json.loads(arrays["meta"].tobytes()) | {"format": number}
    arrays["meta"] = np.frombuffer(json.dumps(meta).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


@pytest.mark.parametrize("damage", [b"", b"not a map", None])
def test_a_damaged_map_is_one_clear_line(tmp_path: Path, damage: bytes | None) -> None:
    path = tmp_path / "a.topomap"
    save_map(square(), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    with pytest.raises(DataError, match=r"a\.topomap: not a topomap map, or damaged") as error:
        load_map(path)
    assert "\n" not in str(error.value)


def test_a_missing_map_and_an_unwritable_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="can't be read"):
        load_map(tmp_path / "none.topomap")
    with pytest.raises(DataError, match="can't be written"):
        save_map(square(), tmp_path / "none" / "a.topomap")


def test_numbers_places_drives_and_experience_load_back(tmp_path: Path) -> None:
    topo = square()
    topo.places = {"desk": 3, "door": 5}
    topo.experience.passed(0, 1, 2.5)
    topo.experience.failed(1, 2, 77)
    topo.view = "90x12x4"
    gap = Increments(np.array([200 * STEP_NS]), np.zeros((1, 3)), np.diag([1e4, 1e4, 9.0])[None])
    topo.add(Node(200 * STEP_NS, 100.0, snapshot(17)), gap, jump=True)
    loaded = from_bytes(to_bytes(topo))
    assert (loaded.places, loaded.names, loaded.jumps, loaded.view) == (topo.places, topo.names, {17}, "90x12x4")
    assert list(loaded.experience) == list(topo.experience)
    assert not loaded.graph.has_edge(16, 17)
    assert to_bytes(loaded) == to_bytes(topo)


def changed(meta: dict[str, object] | None = None, **arrays: object) -> bytes:
    """A map's bytes with some of its JSON and arrays replaced; None leaves an array out."""
    with np.load(io.BytesIO(to_bytes(square()))) as file:
        held = {name: file[name] for name in file.files}
    held |= arrays  # type: ignore[arg-type]
    held["meta"] = np.frombuffer(json.dumps(json.loads(held["meta"].tobytes()) | (meta or {})).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **{name: array for name, array in held.items() if array is not None})
    return buffer.getvalue()


NAN = np.full((17, 3), np.nan)
CRAFTED: dict[str, tuple[bytes, str]] = {
    "newer": (changed({"format": 9, "writer": "topomap 7.1"}), r"map format 9, written by topomap 7\.1; .* 1 to 5"),
    "no format": (changed({"format": "x"}), "doesn't say which format"),
    "poses that are no numbers": (changed(poses=NAN), "expected numbers in poses"),
    "poses of other nodes": (changed(poses=np.zeros((16, 3))), "expected poses for 17 nodes"),
    "no poses": (changed(poses=None), "poses is missing"),
    "objects": (changed(poses=np.zeros((17, 3), np.float32)), "poses is float32"),
    "a chain that leaves nodes out": (changed(chain=np.zeros(17, np.int64)), "a chain of all nodes"),
    "a closure with nobody": (changed(closure_ends=np.array([[0, 99]])), "closures between nodes that there are"),
    "a closure from behind": (changed(closure_ends=np.array([[0, -1]])), "closures between nodes that there are"),
    "a negative variance": (changed(closure_covariance=-np.eye(3)[None]), "variances in closure_covariance"),
    "image ends beyond the images": (changed(image_ends=np.full(17, 10**12)), "image ends within the images"),
    "ranges of nobody": (changed(ranges=np.zeros(5, np.float32)), r"expected 1224 ranges"),
    "edges that end elsewhere": (changed(edge_ends=np.full(16, 2**62)), "odometry on each edge"),
    "time that runs backwards": (changed(stamps_ns=np.arange(17, 0, -1)), "stamps that rise"),
    "two nodes of one number": (changed(names=np.zeros(17, np.int64)), "a number of its own"),
    "a place that isn't": (changed({"places": {"desk": 99}}), "places at nodes that there are"),
    "a rig as wide as the sea": (changed({"rigs": [asdict(RIG) | {"width": 10**9}]}), "a rig's width"),
    "a rig without end": (changed({"rigs": [asdict(RIG) | {"focal": float("inf")}]}), "a rig that is numbers"),
    "parts that the robot hides beyond all": (
        changed({"rigs": [asdict(RIG) | {"hidden": [[1.0, 7.0]]}]}),
        "hidden parts within a turn",
    ),
    "parts that the robot hides of words": (
        changed({"rigs": [asdict(RIG) | {"hidden": [["a", "b"]]}]}),
        "hidden parts within a turn",
    ),
    "a part that the robot hides without an end": (
        changed({"rigs": [asdict(RIG) | {"hidden": [[1.0]]}]}),
        "not enough values",
    ),
    "parts that the robot hides as a number": (changed({"rigs": [asdict(RIG) | {"hidden": 3}]}), "not iterable"),
    "a calibration of nothing": (
        changed({"calibration": {"rotation_scale": 0.0, "curvature": 0.0, "distance_scale": 1.0}}),
        "scales near 1",
    ),
    "a view of its own": (changed({"view": "1x1x1"}), "16 to 720 columns"),
}


@pytest.mark.parametrize(("data", "said"), CRAFTED.values(), ids=CRAFTED)
def test_a_crafted_map_is_one_clear_line(tmp_path: Path, data: bytes, said: str) -> None:
    path = tmp_path / "a.topomap"
    path.write_bytes(data)
    with pytest.raises(DataError, match=said) as error:
        load_map(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def bomb(claimed: int, count: int) -> bytes:
    """A small zip whose poses are zeros, `count` of them, under a header that claims as many rows."""
    content = io.BytesIO()
    np.lib.format.write_array_header_1_0(content, {"descr": "<f8", "fortran_order": False, "shape": (claimed, 3)})
    buffer = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(to_bytes(square()))) as old, zipfile.ZipFile(buffer, "w") as new:
        for member in old.infolist():
            data = old.read(member)
            data = content.getvalue() + bytes(24 * count) if member.filename == "poses.npy" else data
            new.writestr(member.filename, data, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


@pytest.mark.parametrize(("claimed", "count"), [(10**12, 1), (10**7, 10**7), (17, 10**6), (2**62, 0)])
def test_a_map_that_would_fill_the_memory_is_refused_before_it_does(claimed: int, count: int) -> None:
    data = bomb(claimed, count)
    tracemalloc.start()
    with pytest.raises(DataError, match="damaged"):
        from_bytes(data)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 100e6


@given(st.data())
@settings(max_examples=300, deadline=None)
def test_whatever_becomes_of_its_bytes_a_map_loads_or_says_so(data: st.DataObject) -> None:
    whole = bytearray(WHOLE)
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] ^= data.draw(st.integers(1, 255))
    cut = data.draw(st.one_of(st.just(len(whole)), st.integers(0, len(whole))))
    said = ""
    try:
        from_bytes(bytes(whole[:cut]))
    except DataError as error:
        said = str(error)
    assert "\n" not in said


@pytest.mark.parametrize(
    ("head", "said"),
    [(b"\x89MCAP0\r\n", "an MCAP log"), (b"\x80\x04\x95", "a Python pickle"), (b"", "empty"), (b"\x89PNG", "PNG")],
)
def test_another_kind_of_file_is_called_by_its_name(tmp_path: Path, head: bytes, said: str) -> None:
    path = tmp_path / "a.topomap"
    path.write_bytes(head + bytes(100) if head else b"")
    with pytest.raises(DataError, match=said):
        load_map(path)


KILLED = """
import os, signal, sys
sys.path.insert(0, {helpers!r})
from maps import square
from topomap.mapping import mapfile
from topomap.mapping.mapfile import writer
topo = square(40)
kill = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
if {when!r} == "writing":
    whole = writer.to_bytes(topo)
    writer.to_bytes = lambda _: whole[: len(whole) // 2]
    writer.os = type("os", (), dict(getpid=os.getpid, fsync=kill))
else:
    writer.os = type("os", (), dict(getpid=os.getpid, fsync=os.fsync, replace=kill))
mapfile.save_map(topo, sys.argv[1])
"""


@pytest.mark.parametrize("when", ["writing", "renaming"])
def test_killed_while_saving_the_old_map_is_whole(tmp_path: Path, when: str) -> None:
    path = tmp_path / "a.topomap"
    save_map(square(), path)
    before = path.read_bytes()
    helpers = str(Path(__file__).parents[1] / "helpers")
    done = subprocess.run([sys.executable, "-c", KILLED.format(helpers=helpers, when=when), str(path)], check=False)
    assert done.returncode == -9
    assert path.read_bytes() == before
    save_map(square(5), path)
    assert len(load_map(path).nodes) == 21


WHOLE = to_bytes(square())
