"""bench graphs: the injection test."""

from __future__ import annotations

from pathlib import Path

import typer

from topomap.cli.bench_commands import benches
from topomap.cli.console import console, grid, show_wide

HEADINGS = ("graph", "false", "method", "runs", "stopped", "precision, least", "false kept, most", "recall",
            "recall, least", "ATE [m]", "odometry [m]", "time [s]")  # fmt: skip


def add_to(app: typer.Typer) -> None:
    """Add the command to `topomap bench`, which bench_commands adds to the program."""
    benches.command()(graphs)


def graphs(
    sets: str = typer.Option(
        "intel,CSAIL,manhattanOlson3500,w10000", "--set", help="Pose graphs, comma-separated: names or files."
    ),
    seeds: str = typer.Option("0-4", help="Seeds of what is injected, e.g. 0-4 or 0,2."),
    peers: str = typer.Option("all", help="Peers of gtsam, comma-separated; 'all' or 'none'."),
    limit: float = typer.Option(60.0, min=1.0, help="A peer's run is stopped after so many seconds."),
    large_seeds: int = typer.Option(1, min=0, help="On so many of the seeds peers run where nodes are over 2,000."),
    out: Path = typer.Option(Path("runs") / "bench" / "graphs", help="Folder for table and figure."),
) -> None:
    """Inject false closures into pose graphs: precision, recall, error and time beside gtsam's optimisers."""
    from topomap.app import graph_bench
    from topomap.app.words import parse_seeds
    from topomap.bench.pose_graphs.bench import PeerLimits
    from topomap.mapping.optimizer.peers import PEERS

    chosen = list(PEERS) if peers == "all" else [] if peers == "none" else peers.split(",")
    if unknown := [name for name in chosen if name not in PEERS]:
        raise typer.BadParameter(f"no peer '{unknown[0]}': there are {', '.join(PEERS)}", param_hint="--peers")
    found = graph_bench.read_sets(sets.split(","))
    with console.status("measuring") as status:
        rows = graph_bench.run_bench(
            found,
            parse_seeds(seeds),
            chosen,
            PeerLimits(limit, large_seeds),
            lambda row: status.update(f"{row.graph} {row.false_share:.0%} {row.method}"),
        )
    title = f"injected false closures; a run of a peer is stopped after {limit:g} s"
    shown = grid(title, HEADINGS)
    for line in graph_bench.table(rows):
        shown.add_row(*line)
    show_wide(shown)
    for path in graph_bench.write_bench(rows, out):
        console.print(str(path), soft_wrap=True)
