"""What every command shows: a bar on a terminal, nothing in a pipe."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from topomap.cli import console


@pytest.mark.parametrize("terminal", [True, False])
def test_a_share_is_shown_on_a_terminal_alone(monkeypatch: pytest.MonkeyPatch, terminal: bool) -> None:
    text = io.StringIO()
    monkeypatch.setattr(console, "console", Console(file=text, force_terminal=terminal, width=100))
    with console.share("ring") as told:
        told(0.5, "weighing [closures]")
    assert ("ring: weighing [closures]" in text.getvalue()) is terminal
    assert bool(text.getvalue().strip()) is terminal
