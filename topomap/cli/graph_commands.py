"""bench graphs: the injection test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from topomap.cli.bench_commands import KEEP, OUT, benches
from topomap.cli.console import console, grid, show_wide

if TYPE_CHECKING:
    from topomap.bench.pose_graphs.bench import Row


def add_to(app: typer.Typer) -> None:
    """Add the command to `topomap bench`, which bench_commands adds to the program."""
    benches.command()(graphs)


def graphs(
    names: str = typer.Option(
        "intel,CSAIL,manhattanOlson3500,w10000",
        "--graphs",
        help="Pose graphs, comma-separated: files or known names; their own closures are taken for true.",
    ),
    kinds: str = typer.Option("all", help="Kinds of false ones: random,close,groups-5,groups-10,mixed, or 'all'."),
    shares: str = typer.Option("0,.2,.5,.8,.9", help="Shares of all closures that are false."),
    seeds: str = typer.Option("0-2", help="Seeds of what is injected, e.g. 0-4 or 0,2."),
    peers: str = typer.Option("all", help="gtsam's DCS,GNC,Huber,Levenberg-Marquardt, or 'all', or 'none'."),
    limit: float = typer.Option(
        120.0,
        min=0.1,
        help="A peer is stopped after so many seconds of optimising, and not asked where more are false.",
    ),
    fresh: bool = typer.Option(False, "--fresh", help="Measure anew what is known already."),
    out: Path = typer.Option(OUT / "graphs", help="Folder for table and figures."),
    keep: Path | None = KEEP,
) -> None:
    """Inject false closures into pose graphs: precision, recall, error and time beside gtsam's optimisers."""
    from topomap.app import graph_bench
    from topomap.app.words import parse_names, parse_seeds, parse_shares
    from topomap.bench.pool import Store, default_folder
    from topomap.bench.pose_graphs.bench import Design
    from topomap.bench.pose_graphs.injection import KINDS
    from topomap.bench.pose_graphs.kept import KEPT, KEYS, kept_rows
    from topomap.bench.pose_graphs.table import HEADINGS, cells, texts
    from topomap.experiments.results import add_results
    from topomap.mapping.optimizer.peers import PEERS

    design = Design(
        parse_names(kinds, KINDS), parse_shares(shares), parse_seeds(seeds), parse_names(peers, tuple(PEERS)), limit
    )
    found = graph_bench.read_sets(names.split(","))
    store = Store(None if fresh else default_folder())
    with console.status("measuring") as status:

        def told(made: tuple[Row, ...]) -> None:
            status.update(
                f"{made[0].graph} {made[0].kind} {made[0].false_share:.0%} of seed {made[0].seed} is measured"
            )
            if keep is not None:
                add_results(keep, KEPT, kept_rows(made, limit), KEYS)

        rows, written = graph_bench.run_bench(found, design, out, told, store)
    shown = grid(f"injected false closures; a peer is stopped after {limit:g} s", HEADINGS)
    for cell in cells(rows):
        shown.add_row(*texts(cell))
    show_wide(shown)
    for line in graph_bench.short(rows if keep is None else _show_kept(keep)):
        console.print(f"falls short: {line}", soft_wrap=True, markup=False)
    for path in written:
        console.print(str(path), soft_wrap=True)


def _show_kept(keep: Path) -> list[Row]:
    """Show the worst of all that a file of figures holds, a line a graph and kind; return its rows."""
    from topomap.bench.pose_graphs.kept import rows_of
    from topomap.bench.pose_graphs.overview import overview
    from topomap.experiments.results import read_results

    rows = rows_of(read_results(keep).rows)
    headings, lines = overview(rows)
    shown = grid(f"worst of all in {keep}: precision / recall / ATE [m]", headings)
    for line in lines:
        shown.add_row(*line)
    show_wide(shown)
    return rows
