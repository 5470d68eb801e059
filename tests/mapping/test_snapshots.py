"""When a snapshot is kept."""

from __future__ import annotations

from topomap.mapping.places.snapshots import SnapshotSettings, View, make_rule


def test_a_changed_view_is_kept_after_the_least_way() -> None:
    rule = make_rule(SnapshotSettings(threshold=0.8, min_travel=0.25))
    assert rule.judge(View(0.9, 0.1, 0.1)) is None
    assert rule.judge(View(0.7, 0.1, 0.5)) is None
    assert rule.judge(View(0.9, 0.1, 0.5)) == "view changed"


def test_a_dull_way_is_kept_after_the_longest_way() -> None:
    rule = make_rule(SnapshotSettings(max_travel=1.0))
    assert rule.judge(View(0.1, 0.0, 1.0)) == "far"


def test_a_parked_robot_never_spawns_snapshots() -> None:
    rule = make_rule(SnapshotSettings())
    assert not any(rule.judge(View(0.2, 0.2, 0.0)) for _ in range(1000))


def test_the_accumulated_rule_counts_noise_as_change() -> None:
    rule = make_rule(SnapshotSettings(rule="accumulated", threshold=1.0))
    kept = [i for i in range(100) if rule.judge(View(0.2, 0.11, 0.0))]
    assert kept[:3] == [9, 19, 29]
