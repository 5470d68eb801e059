"""The table of all methods: which row of the survey each is, where it comes from, what it needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import Literal

from topomap.vision.compass import ALIGNERS
from topomap.vision.contracts import Needs
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS

Kind = Literal["aligner", "method", "references", "policy"]
_FAMILY = {"A": "alignment", "H": "homing", "own": "beyond the thesis"}
ROWS: dict[str, tuple[str, str]] = {
    "visual-compass": ("A1", "2.6; Zeil et al. 2003"),
    "visual-compass-sad": ("A1", "2.6, as printed"),
    "scale-plane": ("A2", "2.6.4.4; Horst, Möller 2017"),
    "phase-correlation": ("A3", "2.6.4.4; Kuglin, Hines 1975"),
    "phase-correlation-sum": ("A3", "2.6.4.4; Kuglin, Hines 1975"),
    "phase-scale": ("A4", "2.6.4.4"),
    "rearrangement": ("A5", "2.6.4.3"),
    "min-warping-compass": ("A6", "2.5.2.2; Möller et al. 2010"),
    "min-warping-near-compass": ("A6", "2.5.2.2, near A1"),
    "given": ("A7", "2.6.4.1"),
    "convergence-points": ("A8", "3.20-3.22, fig. 3.2"),
    "epipolar-compass": ("own", "planar epipolar geometry"),
    "alv": ("H1", "2.2; Ramisa et al. 2011"),
    "alv-all": ("H1", "2.2; Lambrinos et al. 2000"),
    "alv-markers": ("H1", "2.2, 2.6.5.3"),
    "acv": ("H2", "2.3; Weber et al. 1999"),
    "delv": ("H3", "2.4; Yu, Kim 2010"),
    "delv-full": ("H3", "2.4, all pairings"),
    "delv-quantised": ("H3", "2.4, fig. 5.33"),
    "comalv": ("H4", "2.5.1.1; Hafner 2001"),
    "comalv-edges": ("H4", "2.5.1.1, edge-weighted"),
    "comalv-references": ("H4", "2.5.1.1, Jacobian of three references"),
    "mcomalv": ("H5", "2.7"),
    "did": ("H6", "2.5; Zeil et al. 2003"),
    "did-far": ("H6", "2.5, references at 0.3 m"),
    "did-basic": ("H7", "2.5.3"),
    "did-gradient-2": ("H7", "2.5.3.1; Möller, Vardy 2006"),
    "did-gradient-4": ("H7", "2.5.3.1"),
    "did-newton-4": ("H7", "2.5.3.2"),
    "did-newton-8": ("H7", "2.5.3.2"),
    "mfdid-gradient": ("H8", "2.5.3.4; Möller, Vardy 2006"),
    "mfdid-newton": ("H8", "2.5.3.4"),
    "warping-1d": ("H9", "2.5.2.1; Franz et al. 1998"),
    "warping-2d": ("H10", "2.5.2.2; Möller et al. 2010"),
    "min-warping": ("H11", "2.5.2.2; Möller et al. 2010"),
    "moment-centroid": ("H12", "3.9, 3.16"),
    "moment-centroid-rgb": ("H12", "3.17-3.23"),
    "moment-2": ("H13", "3.34"),
    "moment-3": ("H13", "3.34"),
    "moment-pixel": ("H13", "A.20"),
    "moment-area": ("H13", "3.40"),
    "moment-area-rgb": ("H13", "3.40, 3.23"),
    "moment-area-hsv": ("H13", "3.40, 3.23"),
    "moment-ground": ("H13, H17", "3.40, 5.1.1.2"),
    "moment-colour-only": ("H13, H17", "3.34, equal distances"),
    "area-centroid": ("H15", "3.1.3"),
    "convergence-point": ("H16", "3.29-3.33"),
    "bipolar-masks": ("H18", "4.1-4.3"),
    "random-masks": ("H19", "4.8-4.12"),
    "random-masks-references": ("H19", "4.8-4.12, Jacobian of three references"),
    "masks-3": ("H20", "4.13-4.15"),
    "masks-3-even": ("H20", "4.13-4.15, fig. 4.35"),
    "pixel-landmarks": ("H21, H17", "5.2-5.5, ground line"),
    "pixel-landmarks-range": ("H21", "5.2-5.5"),
    "run-down": ("H22, H23", "5.6-5.12"),
    "stationary-1d": ("H24", "5.1.3.3"),
    "stationary-2d": ("H25", "5.1.3.4; Farnebäck 2003"),
    "dtw-wing": ("H26", "5.15"),
    "dtw-unifying": ("H27", "5.16"),
    "dtw-inhibited": ("H28", "5.1.3.8"),
    "dtw-swing": ("H28", "5.1.3.4"),
    "epipolar": ("own", "planar epipolar geometry; Ortín, Montiel 2001"),
    "auto": ("own", "picks by what is there"),
}
"""Row and source of every method; where an aligner and a method share a name, the aligner's is NAME-compass."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A line of the table. needs: of the input, in words; homes: whether it claims to; defaults: fields and values."""

    row: str
    name: str
    family: str
    kind: Kind
    needs: str
    homes: bool | None
    source: str
    defaults: str


def entries() -> Iterator[Entry]:
    """Yield every aligner, method, method with references and policy."""
    for name, aligner in ALIGNERS.items():
        yield _entry(name, f"{name}-compass" if f"{name}-compass" in ROWS else name, "aligner", aligner, "", None)
    for name, method in METHODS.items():
        yield _entry(name, name, "method", method, in_words(method.needs), method.claims_homing)
    for name, referenced in REFERENCE_METHODS.items():
        needs = f"{in_words(referenced.needs)}, references at {referenced.step:g} m"
        yield _entry(name, name, "references", referenced, needs, referenced.claims_homing)
    for name, policy in POLICIES.items():
        yield _entry(name, name, "policy", policy, in_words(policy.needs), policy.claims_homing)


def _entry(name: str, key: str, kind: Kind, thing: object, needs: str, homes: bool | None) -> Entry:
    row, source = ROWS[key]
    needs = {"rearrangement": "ranges", "convergence-points": "ranges, colour", "given": "heading"}.get(name, needs)
    return Entry(row, name, _FAMILY.get(row[0], _FAMILY["own"]), kind, needs, homes, source, defaults(thing))


def in_words(needs: Needs) -> str:
    """Return what is needed, in words."""
    named = {
        "compass": needs.compass,
        "ranges": needs.ranges,
        "colour": needs.colour,
        "camera height": needs.camera_height,
    }
    return ", ".join(word for word, wanted in named.items() if wanted)


def defaults(thing: object) -> str:
    """Return the parameters that are plain values, as name=value."""
    if not is_dataclass(thing):
        return ""
    values = {f.name: getattr(thing, f.name) for f in fields(thing)}
    plain = {n: v for n, v in values.items() if isinstance(v, (int, float, str, bool))}
    return " ".join(f"{n}={v:.4g}" if isinstance(v, float) else f"{n}={v}" for n, v in plain.items())
