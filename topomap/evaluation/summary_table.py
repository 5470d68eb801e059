"""The summary's rows for people: a terminal's table and the report's first page."""

from __future__ import annotations

from collections.abc import Mapping

Summary = dict[str, object]
Part = Mapping[str, object]
MISSING = "-"


def table_rows(summary: Summary) -> list[tuple[str, str]]:
    """Return label and value of each row of the small table; what doesn't apply is a dash."""
    closures, home = _part(summary, "closures"), _part(summary, "home")
    return [
        ("world", f"{summary['world']}, seed {_text(summary['seed'])}"),
        ("driven", f"{_text(summary['distance_m'], '.1f')} m in {_text(summary['steps'])} steps"),
        ("speed", f"{_text(summary['steps_per_s'], '.0f')} steps/s"),
        ("snapshots", _text(summary["snapshots"])),
        ("closures", _closures(closures)),
        ("recall", _recall(closures)),
        ("dead reckoning ATE", _ate(_part(summary, "dead_reckoning_ate_m"))),
        ("online ATE", _ate(_part(summary, "online_ate_m"))),
        ("map ATE", _ate(_part(summary, "map_ate_m"))),
        ("rotation scale", _scale(_part(summary, "rotation_scale"), ".4f", "")),
        ("distance scale", _scale(_part(summary, "distance_scale"), ".4f", "")),
        ("curvature", _scale(_part(summary, "curvature"), ".5f", " rad/m")),
        ("home", _home(home)),
        *_legs(summary.get("legs")),
        ("declared sigma x", _odometer(_part(summary, "trust"))),
        ("camera leans", _mount(_part(summary, "mount")) if "mount" in summary else MISSING),
        ("map kept", str(_part(summary, "trust")["kept"] or MISSING)),
        ("graph hash", str(summary["graph_hash"])[:16] or MISSING),
        *_troubles(summary),
    ]


def _troubles(summary: Summary) -> list[tuple[str, str]]:
    """Return a row for what ended the run and one for what its log lacks, where there is such a thing."""
    rows = [("fault", str(summary["fault"]))] if summary.get("fault") else []
    log = summary.get("log")
    if isinstance(log, Mapping) and log["state"] != "whole":
        rows.append(("log", f"{log['state']}: {log['note']}"))
    return rows


def _legs(legs: object) -> list[tuple[str, str]]:
    """Return a row for the goals of a patrol, where there was more than one."""
    if not isinstance(legs, list) or len(legs) < 2:
        return []
    false = sum(leg["claimed"] is True and leg["within_0_3_m"] is False for leg in legs)
    said = sum(leg["claimed"] is True for leg in legs)
    errors = [leg["error_m"] for leg in legs if leg["claimed"] and leg["error_m"] is not None]
    worst = f", {max(errors):.2f} m off at most" if errors else ""
    way = sum(leg["way_m"] or 0.0 for leg in legs)
    return [("legs", f"{said} of {len(legs)} claimed, {false} falsely{worst}, {way:.1f} m")]


def _part(summary: Summary, key: str) -> Part:
    part = summary[key]
    assert isinstance(part, Mapping)
    return part


def _text(value: object, form: str = "") -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return format(value, form) if isinstance(value, int | float) else MISSING


def _share(value: object) -> str:
    return f"{100 * value:.0f} %" if isinstance(value, int | float) else MISSING


def _closures(part: Part) -> str:
    return (
        f"{part['accepted']} accepted of {part['proposed']} proposed, {_text(part['false'])} false"
        f" ({_text(part['false_ever'])} ever), {_text(part['gross'])} gross"
    )


def _recall(part: Part) -> str:
    """Say the share of passes closed at any time within 1 m, and by what stands within the pass itself."""
    return (
        f"{_share(part['recall'])} of {_text(part['possible'])} possible,"
        f" {_share(part['recall_standing'])} by standing closures without a margin"
    )


def _ate(part: Part) -> str:
    return f"{_text(part['se2'], '.3f')} m SE(2), {_text(part['sim2'], '.3f')} m Sim(2)"


def _scale(part: Part, form: str, unit: str) -> str:
    sigma, true = _text(part["sigma"], form), _text(part["true"], form)
    if part["found"] is None:
        return f"unobserved, true {true}{unit}" if part["sigma"] is not None else MISSING
    return f"{_text(part['found'], form)} ± {sigma}, true {true}{unit}"


def _mount(part: Part) -> str:
    if part["roll_deg"] is None:
        return "unobserved: nothing upright was seen"
    sway = f", sways by {_text(part['sway_deg'], '.1f')}" if part["sway_deg"] else ""
    return (
        f"{_text(part['roll_deg'], '.2f')} right, {_text(part['pitch_deg'], '.2f')} forward"
        f" ± {_text(part['sigma_deg'], '.2f')} degrees{sway}, {'taken out' if part['taken_out'] else 'left as it is'}"
    )


def _odometer(part: Part) -> str:
    """Say what its declared errors are taken times: sigmas, which people think in, not variances."""
    way, turn = (
        f"{value**0.5:.2f}" if isinstance(value, int | float) else MISSING
        for value in (part["way_noise"], part["turn_noise"])
    )
    return f"{way} (way), {turn} (turn)"


def _home(part: Part) -> str:
    if part["asked"] is None:
        return "- (a replay can't change the drive)"
    if not part["asked"]:
        return "not asked"
    said = "claimed" if part["claimed"] is True else "not claimed"
    return (
        f"{said}, within 0.3 m: {_text(part['within_0_3_m'])}, error {_text(part['error_m'], '.2f')} m,"
        f" path ratio {_text(part['path_ratio'], '.2f')} (of the shortest way {_text(part['shortest_ratio'], '.2f')}),"
        f" collisions {_text(part['collisions'])}"
    )
