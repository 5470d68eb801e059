"""Protobuf bytes looked at before they become objects: two bytes can stand for a record of hundreds."""

from __future__ import annotations

from logs.budget import FIELD_LIMIT

_WIDTHS = {1: 8, 5: 4}
_DELIMITED = 2


def too_many_fields(data: bytes, limit: int = FIELD_LIMIT) -> bool:
    """Return whether a message has more values than the limit; bytes that aren't a message are left to the decoder."""
    place = count = 0
    try:
        while place < len(data) and count <= limit:
            tag, place = _varint(data, place)
            kind = tag & 7
            if kind == _DELIMITED:
                length, place = _varint(data, place)
                place += length
            elif kind in _WIDTHS:
                place += _WIDTHS[kind]
            else:
                _, place = _varint(data, place)
            count += 1
    except IndexError:
        return False
    return count > limit


def _varint(data: bytes, place: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[place]
        value, shift, place = value | (byte & 127) << shift, shift + 7, place + 1
        if byte < 128:
            return value, place
