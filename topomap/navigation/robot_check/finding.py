"""What was found wrong, one line each."""

from __future__ import annotations

from dataclasses import dataclass

from topomap.core.robot import Reading


@dataclass(frozen=True, slots=True)
class Finding:
    """Something a driver does wrong: the reading's field, and what is wrong and what would be right."""

    field: str
    message: str

    def __str__(self) -> str:
        return f"{self.field}: {self.message}"


Readings = list[Reading]
Findings = list[Finding]
