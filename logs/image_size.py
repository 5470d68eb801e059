"""An encoded image's size, read from its first bytes: told before a decoder takes the memory."""

from __future__ import annotations

import struct

_PNG = b"\x89PNG\r\n\x1a\n"
_SIZED = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""JPEG's frame headers, which hold the size; the three others are tables."""
_BARE = frozenset((0x01, *range(0xD0, 0xD9)))
"""Marks without a length."""


def image_size(encoded: bytes) -> tuple[int, int] | None:
    """Return width and height [px] of a PNG or JPEG, None where the bytes don't say."""
    if encoded.startswith(_PNG):
        return struct.unpack(">II", encoded[16:24]) if len(encoded) >= 24 else None
    return _jpeg(encoded) if encoded.startswith(b"\xff\xd8") else None


def _jpeg(data: bytes) -> tuple[int, int] | None:
    place = 2
    while place + 9 <= len(data):
        if data[place] != 0xFF:
            return None
        mark = data[place + 1]
        if mark in _SIZED:
            height, width = struct.unpack_from(">HH", data, place + 5)
            return width, height
        if mark == 0xFF or mark in _BARE:
            place += 1 if mark == 0xFF else 2
        else:
            place += 2 + int(struct.unpack_from(">H", data, place + 2)[0])
    return None
