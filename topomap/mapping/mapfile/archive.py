"""Named arrays in a zip: packed the same way each time, unpacked without trusting what the file says of itself."""

from __future__ import annotations

import io
import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

Array = NDArray[Any]
STORED = frozenset({"images"})  # JPEG and PNG shrink no further
MADE = (1980, 1, 1, 0, 0, 0)  # the same map gives the same bytes
LEVEL = 6
# Measured on maps of three worlds: all arrays unpacked are at most 2.7 times the file. A file may ask for more than
# that, but not for so much that a small one fills the memory.
ROOM, TIMES = 64_000_000, 8
DAMAGED = (zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError, EOFError, NotImplementedError,
           RuntimeError, ValueError, TypeError, KeyError, IndexError, OverflowError,
           AttributeError, SyntaxError)  # fmt: skip
"""What zipfile, NumPy and JSON raise for files that aren't what they say."""


def pack(arrays: Mapping[str, Array]) -> bytes:
    """Return a zip of arrays that `numpy.load` reads as well."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy", MADE)
            member.compress_type = zipfile.ZIP_STORED if name in STORED else zipfile.ZIP_DEFLATED
            content = io.BytesIO()
            npy.write_array(content, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(member, content.getvalue(), compresslevel=LEVEL)
    return buffer.getvalue()


class Archive:
    """An open zip of arrays: nothing is read before its size is known to be sane."""

    def __init__(self, file: IO[bytes]) -> None:
        """Look at the table of contents. Raises ValueError or another of `DAMAGED`."""
        size = file.seek(0, io.SEEK_END)
        file.seek(0)
        self._zip = zipfile.ZipFile(file)
        members = self._zip.infolist()
        unpacked = sum(member.file_size for member in members)
        if unpacked > ROOM + TIMES * size:
            raise ValueError(f"{size} bytes that would unpack to {unpacked}")
        self._members = {member.filename.removesuffix(".npy"): member for member in members}
        if any(member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for member in members):
            raise ValueError("arrays packed in a way that no map is")
        if len(self._members) < len(members):
            raise ValueError("an array is there twice")

    def __contains__(self, name: str) -> bool:
        return name in self._members

    def read(self, name: str, kind: str, columns: tuple[int, ...] = ()) -> Array:
        """Return an array (N, *columns) of a NumPy type such as "<f8"; columns of 0 take any number.

        Raises ValueError or another of `DAMAGED`.
        """
        if name not in self._members:
            raise ValueError(f"{name} is missing")
        member = self._members[name]
        with self._zip.open(member) as content:
            shape, turned, dtype = _header(content)
            if dtype != np.dtype(kind) or turned or not _fits(shape, columns):
                raise ValueError(f"{name} is {dtype} {shape}, not {np.dtype(kind)} {('N', *columns)}")
            count = math.prod(shape) * dtype.itemsize
            if count > member.file_size:
                raise ValueError(f"{name} says it is {shape}, but holds {member.file_size} bytes")
            data = content.read()
        if len(data) != count:
            raise ValueError(f"{name} says it is {shape}, but holds {len(data)} bytes")
        return np.frombuffer(data, dtype).reshape(shape)


def _header(content: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = npy.read_magic(content)
    if version == (1, 0):
        return npy.read_array_header_1_0(content)
    if version == (2, 0):
        return npy.read_array_header_2_0(content)
    raise ValueError(f"an array of NumPy's format {version}")


def _fits(shape: tuple[int, ...], columns: tuple[int, ...]) -> bool:
    rest = shape[1:]
    return (
        len(shape) == 1 + len(columns)
        and min(shape) >= 0
        and all(wanted in (0, there) for wanted, there in zip(columns, rest, strict=True))
    )
