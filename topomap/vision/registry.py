"""All methods by name: found for whoever names one, and as a table that says where each comes from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Literal, TypeVar

from topomap.core.errors import DataError
from topomap.vision.aligned_homing import AlignedHoming, Method
from topomap.vision.compass import ALIGNERS
from topomap.vision.contracts import Aligner, HomingMethod, HomingPolicy, Listed, Needs, ReferenceHoming
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS

T = TypeVar("T")
Kind = Literal["aligner", "method", "references", "policy"]
OWN = "own"
"""The aligner's name that stands for the homing method's own, or the default one where it has none."""
DEFAULT = "min-warping"
_FAMILY = {"A": "alignment", "H": "homing", "own": "beyond the thesis"}


def aligner(chosen: str | Aligner) -> Aligner:
    """Return the aligner of a name, or the object itself. Raises DataError."""
    if isinstance(chosen, str):
        return _named(chosen, ALIGNERS, "aligner")
    if not isinstance(chosen, Aligner):
        raise DataError(f"{chosen!r} is no aligner: it has no method align(current, goal, prior)")
    return chosen


def method(chosen: str | Method | Aligner) -> Method:
    """Return the homing method of a name, with references or a policy too, or the object itself. Raises DataError."""
    if isinstance(chosen, str):
        known: dict[str, Method] = {**METHODS, **REFERENCE_METHODS, **POLICIES}
        alone = [name for name in ALIGNERS if name not in known and _homing_aligner(name) is not None]
        return _named(chosen, known, "homing method", *alone)
    if not isinstance(chosen, (HomingMethod, ReferenceHoming, HomingPolicy)):
        raise DataError(
            f"{chosen!r} is no homing method: it needs needs and claims_homing, and describe and home,"
            " step and home, or start and step (topomap.vision.contracts)"
        )
    return chosen


def aligned_homing(
    chosen: str | Method | Aligner, compass: str | Aligner = OWN, otherwise: str = DEFAULT
) -> AlignedHoming:
    """Return method and aligner as one; each a name or an object. Raises DataError.

    chosen: a homing method, or an aligner that gives home vectors. Where it aligns by itself and no other aligner is
    asked for, it is asked once, near the rotation that odometry tells. otherwise: the aligner of a method without one.
    """
    alone = _homing_aligner(chosen)
    if alone is not None and compass in (OWN, chosen):
        return AlignedHoming(alone)
    if isinstance(chosen, str) and alone is not None and chosen not in METHODS:
        raise DataError(f"homing method {chosen!r} is its own aligner; give it no other than {OWN!r}")
    return AlignedHoming(aligner(otherwise if compass == OWN else compass), method(chosen))


def _homing_aligner(chosen: str | Method | Aligner) -> Aligner | None:
    """Return what aligns and homes at once."""
    if isinstance(chosen, str):
        found = ALIGNERS.get(chosen)
        return found if isinstance(found, Listed) and found.claims_homing else None
    return chosen if isinstance(chosen, Aligner) else None


def _named(name: str, known: Mapping[str, T], what: str, *more: str) -> T:
    if name not in known:
        raise DataError(f"unknown {what} {name!r}; there are {', '.join([*known, *more])}")
    return known[name]


@dataclass(frozen=True, slots=True)
class Entry:
    """A line of the table. needs: of the input, in words; homes: whether it claims to; defaults: fields and values."""

    row: str
    name: str
    family: str
    kind: Kind
    needs: str
    homes: bool
    source: str
    defaults: str


def entries() -> Iterator[Entry]:
    """Yield every aligner, method, method with references and policy."""
    for name, one in ALIGNERS.items():
        yield _entry(name, "aligner", one)
    for name, pairwise in METHODS.items():
        yield _entry(name, "method", pairwise)
    for name, referenced in REFERENCE_METHODS.items():
        yield _entry(name, "references", referenced, f"references at {referenced.step:g} m")
    for name, policy in POLICIES.items():
        yield _entry(name, "policy", policy, "trial moves")


def _entry(name: str, kind: Kind, thing: object, more: str = "") -> Entry:
    if not isinstance(thing, Listed):  # put there by a user, whose own methods need no source
        return Entry(OWN, name, _FAMILY[OWN], kind, more, True, "", defaults(thing))
    row, source = thing.origin.row, thing.origin.source
    needs = ", ".join(word for word in (in_words(thing.needs), more) if word)
    family = _FAMILY.get(row[0], _FAMILY["own"])
    return Entry(row, name, family, kind, needs, thing.claims_homing, source, defaults(thing))


def in_words(needs: Needs) -> str:
    """Return what is needed, in words."""
    return ", ".join(f.name.replace("_", " ") for f in fields(needs) if getattr(needs, f.name))


def defaults(thing: object) -> str:
    """Return the parameters that are plain values, as name=value."""
    if not is_dataclass(thing):
        return ""
    values = {f.name: getattr(thing, f.name) for f in fields(thing)}
    plain = {n: v for n, v in values.items() if isinstance(v, (int, float, str, bool))}
    return " ".join(f"{n}={v:.4g}" if isinstance(v, float) else f"{n}={v}" for n, v in plain.items())
