"""What is tried when a journey gets no further: one step after the other, begun anew once there is progress."""

from __future__ import annotations

from enum import StrEnum


class Trouble(StrEnum):
    """Why a journey gets no further."""

    BLOCKED = "no way through"
    LOST = "lost"
    UNCERTAIN = "the goal isn't recognised"


class Remedy(StrEnum):
    """What is tried, in the order of trying."""

    LOOK = "look again in all directions"
    TURN = "turn and look"
    RETRACE = "go back to the last milestone"
    RELOCALISE = "find out where this is"
    REPLAN = "plan a way round"
    WAIT = "wait for the way to clear"
    GIVE_UP = "give up"


LADDER = {
    Trouble.BLOCKED: (Remedy.LOOK, Remedy.TURN, Remedy.RETRACE, Remedy.REPLAN, Remedy.WAIT, Remedy.GIVE_UP),
    Trouble.LOST: (Remedy.LOOK, Remedy.TURN, Remedy.RETRACE, Remedy.RELOCALISE, Remedy.GIVE_UP),
    Trouble.UNCERTAIN: (Remedy.LOOK, Remedy.TURN, Remedy.RETRACE, Remedy.RELOCALISE, Remedy.GIVE_UP),
}
"""A way that is blocked is seen well enough, and no other way leads to a place that can't be told."""


class Recovery:
    """Which remedy comes next. `made_progress` begins the ladder anew: what helped once may help again elsewhere."""

    def __init__(self) -> None:
        self._tried: dict[Trouble, int] = {}

    def next(self, trouble: Trouble) -> Remedy:
        """Return the next remedy for a trouble; giving up stays the last."""
        ladder = LADDER[trouble]
        rung = self._tried.get(trouble, 0)
        self._tried[trouble] = min(rung + 1, len(ladder) - 1)
        return ladder[rung]

    def made_progress(self) -> None:
        """Forget what was tried."""
        self._tried.clear()
