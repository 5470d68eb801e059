"""A mission in words: teach, home, goto:NODE or PLACE, patrol:A,B,..., hall."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

KINDS = "teach, home, goto:NODE, goto:PLACE, patrol:A,B,... or hall"


class Kind(StrEnum):
    """What kind of mission."""

    TEACH = "teach"
    HOME = "home"
    GOTO = "goto"
    PATROL = "patrol"
    HALL = "hall"


@dataclass(frozen=True, slots=True)
class Wish:
    """A mission: its kind and the nodes or places to go to, in their order."""

    kind: Kind
    targets: tuple[str, ...] = ()


def parse_wish(text: str) -> Wish:
    """Return the mission of a word. Raises ValueError."""
    name, colon, rest = text.partition(":")
    kind = next((kind for kind in Kind if kind.value == name), None)
    targets = tuple(part.strip() for part in rest.split(",")) if colon else ()
    wanted = {Kind.GOTO: 1, Kind.PATROL: len(targets)}.get(kind, 0) if kind else -1
    if kind is None or len(targets) != wanted or not all(targets) or (kind is Kind.PATROL and not targets):
        raise ValueError(f"expected {KINDS}")
    return Wish(kind, targets)
