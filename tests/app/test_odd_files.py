"""What stands where a file should: pipes, devices, folders, huge files, pictures that unpack to gigabytes."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest

from logs.errors import LogError
from logs.mcap_file import McapFile
from sim2d import worlds
from sim2d.errors import WorldError
from topomap.app.config import load_config
from topomap.core.encoded import decode
from topomap.core.errors import ConfigError, DataError
from topomap.datasets.drive_folder.reader import read_folder
from topomap.datasets.g2o.reader import read_graph
from topomap.datasets.image_grid import load_grid
from topomap.datasets.mirror_file import read_mirror
from topomap.mapping.mapfile import load_map
from topomap.recording.true_nodes import read_truths
from topomap.vision.home import load_panorama

READERS: dict[str, tuple[Callable[[Path], object], str, type[Exception]]] = {
    "map": (load_map, "a.topomap", DataError),
    "log": (McapFile, "a.mcap", LogError),
    "settings": (load_config, "a.toml", ConfigError),
    "world": (lambda path: worlds.load(str(path)), "a.toml", WorldError),
    "floor plan": (lambda path: worlds.load(str(path)), "a.yaml", WorldError),
    "pose graph": (read_graph, "a.g2o", DataError),
    "mirror": (read_mirror, "a.toml", DataError),
    "picture": (load_panorama, "a.png", DataError),
    "true poses": (read_truths, "a.csv", DataError),
    "drive": (lambda path: read_folder(path.parent), "drive.csv", DataError),
    "grid": (lambda path: load_grid(path.parent), "grid.toml", DataError),
}


def png(width: int, height: int) -> bytes:
    """A grey picture that says it has so many pixels, and holds none of them."""

    def part(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", zlib.compress(bytes(1000))) + part(b"IEND", b"")


@pytest.mark.parametrize(("read", "name", "error"), READERS.values(), ids=READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "huge"])
def test_what_is_no_file_is_one_line_and_never_waited_for(
    read: Callable[[Path], object], name: str, error: type[Exception], kind: str, tmp_path: Path
) -> None:
    path = tmp_path / name
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    else:
        path.touch()
        os.truncate(path, 2**35)
    with pytest.raises(error) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_a_picture_that_unpacks_to_gigabytes_is_refused_before(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="30000 x 30000 pixels is larger"):
        decode(png(30000, 30000))
    (tmp_path / "plan.png").write_bytes(png(30000, 30000))
    (tmp_path / "plan.yaml").write_text("image: plan.png\nresolution: 0.05\n")
    with pytest.raises(WorldError, match="900000000 pixels, at most"):
        worlds.load(str(tmp_path / "plan.yaml"))
    with pytest.raises(DataError, match="can't be decoded"):
        decode(png(30, 30)[:40])


@pytest.mark.parametrize("text", ["a." * 20000 + "a = 1", "[" + "a." * 20000 + "a]\nb = 1"])
def test_keys_of_thousands_of_parts_are_one_line_at_once(text: str, tmp_path: Path) -> None:
    path = tmp_path / "deep.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match="more than 64 parts"):
        load_config(path)
    with pytest.raises(WorldError, match="more than 64 parts"):
        worlds.load(str(path))


@pytest.mark.parametrize("word", ["a." * 20000 + "a=1", f"a={'[' * 300}{']' * 300}", f"a={'{b=' * 200}1{'}' * 200}"])
def test_a_word_of_thousands_of_parts_is_one_short_line(word: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(None, [word])
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500
