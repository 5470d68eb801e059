"""bench graphs: the injection test."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.bench_commands import OUT, benches
from topomap.cli.console import console, grid, show_wide


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
    limit: float = typer.Option(120.0, min=0.1, help="A peer's optimising is stopped after so many seconds."),
    out: Path = typer.Option(OUT / "graphs", help="Folder for table and figures."),
) -> None:
    """Inject false closures into pose graphs: precision, recall, error and time beside gtsam's optimisers."""
    from topomap.app import graph_bench
    from topomap.app.words import parse_names, parse_seeds, parse_shares
    from topomap.bench.pose_graphs.bench import Design
    from topomap.bench.pose_graphs.injection import KINDS
    from topomap.bench.pose_graphs.table import HEADINGS, cells, texts
    from topomap.mapping.optimizer.peers import PEERS

    design = Design(
        parse_names(kinds, KINDS), parse_shares(shares), parse_seeds(seeds), parse_names(peers, tuple(PEERS)), limit
    )
    found = graph_bench.read_sets(names.split(","))
    with console.status("measuring") as status:
        rows, written = graph_bench.run_bench(
            found,
            design,
            out,
            lambda row: status.update(f"{row.graph} {row.kind} {row.false_share:.0%} {row.method}"),
        )
    shown = grid(f"injected false closures; a peer is stopped after {limit:g} s", HEADINGS)
    for cell in cells(rows):
        shown.add_row(*texts(cell))
    show_wide(shown)
    for line in graph_bench.short(rows):
        console.print(f"falls short: {line}", soft_wrap=True, markup=False)
    for path in written:
        console.print(str(path), soft_wrap=True)
