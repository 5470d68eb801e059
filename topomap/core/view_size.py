"""How large a stored view is: all of the panorama, or columns x rows x bits of grey."""

from __future__ import annotations

from dataclasses import dataclass

from topomap.core.errors import DataError

VIEWS = ("full", "90x12x4", "72x10x3")
"""Beyond the whole panorama, those that were measured; any other size can be asked for as well."""


@dataclass(frozen=True, slots=True)
class ViewSize:
    """Columns and rows [pixels], and bits of grey of each."""

    columns: int
    rows: int
    bits: int


def parse_view(text: object) -> ViewSize | None:
    """Return the size of "COLUMNSxROWSxBITS", None for "full". Raises DataError."""
    if text == "full":
        return None
    parts = text.split("x") if isinstance(text, str) else []
    if len(parts) != 3 or not all(part.isascii() and part.isdigit() and len(part) < 5 for part in parts):
        raise DataError(f"view {text!r}: expected full or COLUMNSxROWSxBITS, as in 90x12x4")
    columns, rows, bits = map(int, parts)
    if not (16 <= columns <= 720 and 4 <= rows <= 200 and 1 <= bits <= 8):
        raise DataError(f"view {text!r}: expected 16 to 720 columns, 4 to 200 rows and 1 to 8 bits")
    return ViewSize(columns, rows, bits)
