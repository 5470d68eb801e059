"""The report stands alone, says why a figure is missing and is the same every time."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from synthetic_run import candidate, decide, make_run

from topomap.core.records import Verdict
from topomap.report.figures.catalogue import FIGURES, FigureKind
from topomap.report.figures.routes import routes
from topomap.report.figures.style import BLACK, BLUE, RED
from topomap.report.report import LEDGER_LIMIT, ledger_parts, render, write_report

RUN = make_run()
BARE = replace(
    RUN,
    truth=None,
    difference=None,
    place_difference=None,
    first_closure=(),
    goal_node=None,
    decisions=(),
    stage_ms={},
)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(RUN, path)
    assert path.stat().st_size < 5_000_000
    return path.read_text(encoding="utf-8")


def test_every_figure_is_in_the_file(page: str) -> None:
    assert all(kind.missing(RUN) is None for kind in FIGURES)
    assert page.count('<img src="data:image/') == len(FIGURES)
    assert "Left out" not in page


def test_nothing_is_fetched(page: str) -> None:
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert "<script" not in page
    assert "@import" not in page
    assert "url(" not in re.sub(r"data:[^\"]*", "", page)


def test_the_ledger_says_verdict_reason_score_and_truth(page: str) -> None:
    text = re.sub(r"data:[^\"]*", "", page)
    assert "accepted: accepted: made up" in text
    assert "before: pending: pending: made up" in text
    assert "difference 0.31" in text
    assert '<td class="true">true</td>' in text
    assert '<td class="gross">gross</td>' in text


def test_what_comes_from_outside_is_escaped() -> None:
    spiteful = replace(RUN, world="<b>room</b>", truth=None, difference=None, place_difference=None, first_closure=())
    assert "<b>room</b>" not in render(spiteful)


def test_words_in_figures_are_no_formulas_and_steer_no_terminal() -> None:
    labels = ((0.0, 0.0, "$\\frac{$"), (1.0, 1.0, "\x1b[2J $x$ [/x]"))
    figure = routes(replace(RUN, plan=replace(RUN.plan, labels=labels)))
    figure.savefig(io.BytesIO(), format="svg")
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert "\\$\\frac{\\$" in texts
    assert "\\x1b[2J \\$x\\$ [/x]" in texts


def test_figures_that_do_not_apply_are_left_out_with_a_reason() -> None:
    text = render(BARE)
    assert text.count("<img") == 1
    assert text.count("Left out: ") == len(FIGURES) - 1
    assert "because the robot wasn&#39;t asked to go home" in text


def test_the_same_run_gives_the_same_bytes(page: str) -> None:
    assert render(make_run()) == page


def test_a_run_without_a_step_still_has_a_report() -> None:
    none = np.zeros((0, 3))
    empty = replace(
        RUN, stamps_ns=np.zeros(0, dtype=np.int64), dead_reckoning=none, online=none, final=none, truth=none,
        driven=None, contact=None, difference=None, place_difference=None, homing_difference=None, nodes=(),
        decisions=(), goal_node=None, first_closure=(), stage_ms={},
    )  # fmt: skip
    assert "the run has no steps" in render(empty)


def test_a_long_ledger_is_cut_and_says_so() -> None:
    many = tuple(decide(candidate(RUN, 300 + k, 8), Verdict.REFUSED) for k in range(LEDGER_LIMIT // 2))
    more = tuple(decide(candidate(RUN, 300 + k, 16), Verdict.REFUSED) for k in range(LEDGER_LIMIT // 2 + 7))
    refused = ledger_parts(replace(RUN, decisions=many + more))[-1]
    assert (len(refused.rows), refused.left_out) == (LEDGER_LIMIT, 7)


def test_svg_figures_are_svg(page: str) -> None:
    first = re.search(r"data:image/svg\+xml;base64,([^\"]+)", page)
    assert first is not None
    assert b"<svg" in base64.b64decode(first.group(1))[:600]


def test_an_unwritable_place_is_an_os_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OSError, match="file"):
        write_report(BARE, tmp_path / "file" / "report.html")


@pytest.mark.parametrize("kind", FIGURES, ids=lambda kind: kind.name)
def test_every_figure_draws_a_data_set_without_headings_and_calibration(kind: FigureKind) -> None:
    assert RUN.truth is not None
    headless = np.column_stack([RUN.truth[:, :2], np.full(len(RUN.truth), np.nan)])
    figure = kind.draw(replace(RUN, truth=headless, calibration=None))
    assert figure.axes
    assert len(figure_bytes(figure)) > 5_000


def figure_bytes(figure: Figure) -> bytes:
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=60)
    return target.getvalue()


def test_the_routes_keep_the_colours_of_the_thesis() -> None:
    lines = {str(line.get_label()): str(line.get_color()) for line in routes(RUN).axes[0].get_lines()}
    assert lines["dead reckoning"] == BLUE
    assert lines["map"] == RED
    assert lines["truth"] == BLACK
    assert {"snapshot", "closure, true", "closure, false"} <= set(lines)


def test_a_lone_route_without_truth_stays_in_the_map_s_frame() -> None:
    axes = routes(replace(RUN, truth=None)).axes[0]
    assert axes.get_title(loc="left") == "Routes (map frame)"
    drawn = {str(line.get_label()): line for line in axes.get_lines()}
    assert "truth" not in drawn
    assert drawn["map"].get_xydata() == pytest.approx(RUN.final[:, :2])
    assert "closure, not judged" in drawn
