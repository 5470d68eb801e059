from __future__ import annotations

from topomap.experiments.study_rows import HEAD, study_lines, study_rows


def test_curves_bars_numbers_and_parts_become_rows() -> None:
    values = {
        "far": {"area": {"x": [1.0, 2.0], "y": [3.0, 4.0], "low": [2.0, 3.5], "high": [4.0, 4.5]}},
        "did": {"mean_deg": 20.0, "low": 18.0, "high": 22.0, "below_45": 0.9, "catchment": None, "places": 40},
        "left out": {},
        "missions": 2,
        "errors": [0.5, 0.25],
        "points": [[1.0, 2.0]],
        "said": "5.51",
        "yes": True,
    }
    rows = [dict(zip(HEAD, row, strict=True)) for row in study_rows("x", values)]
    assert [(r["series"], r["at"], r["value"]) for r in rows] == [
        ("far, area", "1", "3"), ("far, area", "2", "4"), ("did", "", "20"), ("missions", "", "2"),
        ("errors", "0", "0.5"), ("errors", "1", "0.25"),
    ]  # fmt: skip
    assert study_lines(rows) == [
        "| far, area | 1: 3 ± 1; 2: 4 ± 0.5 |",
        "| did | 20 ± 2 (40) |",
        "| missions | 2 |",
        "| errors | 0: 0.5; 1: 0.25 |",
    ]
