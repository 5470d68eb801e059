"""Mistakes that once went unnoticed (named.toml), each tried with the test that is said to notice it now."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from mutation.mutants import ROOT, Mutant

FILE = Path(__file__).with_name("named.toml")


@dataclass(frozen=True)
class Named:
    """One mistake: what it is in words, file, text of the source and what it becomes, and a file of tests."""

    what: str
    file: str
    was: str
    now: str
    test: str

    def mutant(self) -> Mutant:
        """Return it as a mutant. Raises ValueError where its text isn't in the source exactly once."""
        source = (ROOT / self.file).read_text(encoding="utf8")
        if source.count(self.was) != 1:
            raise ValueError(f"{self.file}: {self.was!r} stands there {source.count(self.was)} times, not once")
        return Mutant(self.file, 0, self.was, self.now, source.replace(self.was, self.now), "", False)


def named() -> list[Named]:
    """Return all of them."""
    return [Named(**one) for one in tomllib.loads(FILE.read_text(encoding="utf8"))["mistake"]]
