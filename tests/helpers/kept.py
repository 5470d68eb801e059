"""Figures held against those of before: a sign, a constant or a step that changes without being meant to shows there.

`TOPOMAP_ANSWERS=write pytest tests/mapping tests/navigation -k as_before` writes tests/golden/stages anew, after a
change that is meant to change them; the difference of the files then says what it changed.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from topomap.core.records import StepRecord

FOLDER = Path(__file__).parents[1] / "golden" / "stages"
CLOSE = 1e-4
"""Machines differ in the last digits, and what is iterated or summed over a view in some more."""
SMALL = 0.1
"""Of the largest of some figures, or of 1 where that is less: what is smaller still needn't be closer than this is."""
LONG = re.compile(r"-?\d+\.\d{6,}(?:e[-+]\d+)?|-?\d+(?:\.\d+)?e-\d+")
"""Numbers in words as Python prints them, with digits in which machines differ."""
Kept = list[float | str | None]
Figures = Mapping[str, ArrayLike | Sequence[str]]


def as_before(name: str, figures: Figures, part: bool = False, close: float = CLOSE, floor: float = 0.0) -> None:
    """Fail where figures (numbers of any shape, or words) aren't those of the file NAME.json, or a part of them.

    close: share by which machines may differ; floor: by how much at least, where a figure is the place of a minimum.
    """
    path = FOLDER / f"{name.replace(', ', '-').replace(' ', '-')}.json"
    now = {said: _flat(one) for said, one in figures.items()}
    then: dict[str, Kept] = json.loads(path.read_text(encoding="utf8")) if path.exists() else {}
    if os.environ.get("TOPOMAP_ANSWERS") == "write":
        then = then | now if part else now
        then = {said: [LONG.sub(_short, w) if isinstance(w, str) else w for w in one] for said, one in then.items()}
        lines = ",\n".join(f"{json.dumps(said)}: {json.dumps(one)}" for said, one in then.items())
        path.write_text(f"{{\n{lines}\n}}\n", encoding="utf8")
    assert part or list(now) == list(then)
    for said, one in now.items():
        assert len(one) == len(then[said]), said
        largest = max((abs(b) for b in then[said] if isinstance(b, (float, int))), default=1.0)
        least = max(floor, close * SMALL * min(1.0, max(SMALL**2, largest)))
        for k, (a, b) in enumerate(zip(one, then[said], strict=True)):
            assert _same(a, b, close, least), f"{said}[{k}] is {a}, was {b}"


def of_drive(records: Sequence[StepRecord], every: int = 5) -> Figures:
    """Return what a drive's steps saw and decided: poses and belief of some steps, every closure's verdict, nodes."""
    some = records[::every]
    decisions = [d for record in records for d in record.change.decisions]
    evidence = [d.candidate.evidence.measured() for d in decisions]
    return {
        "pose": [record.where.pose.array() for record in some],
        "lost": [record.where.lost for record in some],
        "difference": [record.where.difference for record in some],
        "threshold": [record.change.threshold for record in some],
        "rivals": [sum(rival.weight for rival in record.where.rivals) for record in some],
        "command": [(record.command.forward, record.command.turn) for record in some],
        "events": [record.where.event for record in records if record.where.event],
        "broken": [word for record in records for word in (record.change.broken, record.change.mended) if word],
        "notes": [record.travel.note for record in records if record.travel.note],
        "added": [f"{k}: {one.reason}" for k, record in enumerate(records) for one in record.change.added],
        "verdicts": [f"{d.candidate.match}: {d.verdict}: {d.reason}" for d in decisions],
        "closed": [d.candidate.relative.array() for d in decisions],
        "spread": [np.sqrt(np.diag(d.candidate.covariance)) for d in decisions],
        "measured": [name for one in evidence for name in one],
        "evidence": [value for one in evidence for value in one.values()],
        **whole(records),
    }


def _flat(values: ArrayLike | Sequence[str]) -> Kept:
    found = np.asarray(values).ravel()
    if found.dtype.kind in "US":
        return [str(one) for one in found.tolist()]
    return [float(f"{one:.7g}") if math.isfinite(one) else str(one) for one in found.astype(float).tolist()]


def _short(number: re.Match[str]) -> str:
    return f"{round(float(number[0]), 6) + 0.0:.9g}"


def _same(a: float | str | None, b: float | str | None, close: float, least: float) -> bool:
    if isinstance(a, float) and isinstance(b, (float, int)):
        return abs(a - b) <= max(close * abs(b), least)
    return _alike(a, b) if isinstance(a, str) and isinstance(b, str) else a == b


def _alike(a: str, b: str) -> bool:
    return LONG.sub(_short, a) == LONG.sub(_short, b)


def whole(records: Sequence[StepRecord]) -> Figures:
    """Return for each field of all records, however deep, how many numbers it held, and their sum by random weights."""
    held: dict[str, list[float]] = defaultdict(list)
    for record in records:
        for name, value in _numbers("", record):
            held[name].append((value - records[0].stamp_ns) / 1e9 if abs(value) > 1e11 else value)
    rng = np.random.default_rng(0)
    weights = rng.normal(size=max(len(one) for one in held.values()))
    return {
        f"whole {name}": [len(one), float(np.asarray(one) @ weights[: len(one)]) / math.sqrt(len(one))]
        for name, one in sorted(held.items())
    }


def _numbers(name: str, thing: object) -> Iterator[tuple[str, float]]:
    if is_dataclass(thing):
        for field in fields(thing):
            if field.name != "timings":
                yield from _numbers(f"{name}.{field.name}".lstrip("."), getattr(thing, field.name))
    elif isinstance(thing, np.ndarray) and thing.dtype.kind in "fiub":
        yield from ((name, float(np.nan_to_num(one, nan=9.0, posinf=99.0, neginf=-99.0))) for one in thing.ravel())
    elif isinstance(thing, (tuple, list)):
        for one in thing:
            yield from _numbers(name, one)
    elif isinstance(thing, (bool, int, float)):
        yield name, float(np.nan_to_num(float(thing), nan=9.0, posinf=99.0, neginf=-99.0))
