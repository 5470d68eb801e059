"""What the tests of the closure engine measured of a candidate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

# what a false closure misses by, one of them at least [m, rad]; a recording may state another distance
FALSE_DISTANCE, FALSE_ROTATION = 1.0, math.radians(20.0)


@dataclass(frozen=True, slots=True)
class Evidence:
    """One value a test, None where it wasn't asked.

    difference: of the images, and limit above which nothing would have been proposed; cost of the alignment and its
    ratio to the best rival's; share of the rays that fit; sigmas: how far off the map it is, as a Mahalanobis distance;
    odds: log odds of true over false, looks: what of them is by looks; support: summed similarity of neighbours that
    agree over what is needed; active: 1 if an active check speaks for it; other: values under names
    that this version doesn't know (older logs).
    """

    difference: float | None = None
    limit: float | None = None
    cost: float | None = None
    ratio: float | None = None
    share: float | None = None
    sigmas: float | None = None
    odds: float | None = None
    support: float | None = None
    active: float | None = None
    looks: float | None = None
    other: tuple[tuple[str, float], ...] = ()

    def measured(self) -> dict[str, float]:
        """Return the values that were measured, by name in order."""
        values = {name: getattr(self, name) for name in NAMES}
        return dict(sorted({**{k: v for k, v in values.items() if v is not None}, **dict(self.other)}.items()))

    @staticmethod
    def of(values: Mapping[str, float]) -> Evidence:
        """Return the evidence of values by name."""
        known = {name: value for name, value in values.items() if name in NAMES}
        return Evidence(**known, other=tuple((k, v) for k, v in values.items() if k not in NAMES))


NAMES = tuple(field.name for field in fields(Evidence) if field.name != "other")
