"""campus: more than 5 km of corridors and halls from a seed, every corridor driven at least once."""

from __future__ import annotations

from collections.abc import Iterable

import networkx as nx
import numpy as np

from sim2d.generate.blocks import Blocks, Edge
from sim2d.generate.looks import TONES, Stock, mixed
from sim2d.generate.things import along_walls
from sim2d.shapes import Cylinder, Ground, Look, Point, Route, Spec
from sim2d.streams import stream

HEIGHT, HALF, PITCH = 2.8, 1.0, 24.0  # [m] ceiling, half a corridor's width, from crossing to crossing
HALL = 5.0  # [m] half a hall's side
COLUMNS, ROWS = 16, 13
KEPT = 0.64  # share of the lattice's corridors that are built
Crossing = tuple[int, int]


def campus(seed: int = 1) -> Spec:
    """Return a lattice of corridors with halls at some crossings; another seed gives another campus."""
    corridors = _corridors(stream(seed, "campus corridors"))
    tour = _tour(corridors)
    halls = _halls(corridors, stream(seed, "campus halls"))
    edges = _blocks(corridors, halls).edges()
    tones = [_tone(edge) for edge in edges]
    boxes, rounds = along_walls(edges, 4.0, stream(seed, "campus things"))
    looks = mixed(stream(seed, "campus looks"), 30)
    return Spec(
        name="campus",
        purpose="more than 5 km of corridors and halls: maps of thousands of nodes, driven once with revisits",
        route=Route(ring=tuple(_place(crossing) for crossing in tour), laps=1, radius=0.8),
        floor=Ground(Look((0.45, 0.44, 0.44), "speckle", 3), tile=4.0, gloss=0.1),
        ceiling=Ground(Look((0.84, 0.84, 0.82), "plaster", 4), tile=4.0, lamps=4.0),
        ceiling_height=HEIGHT,
        walls=Stock(looks, HEIGHT).hang(edges, tones, stream(seed, "campus walls")),
        boxes=tuple(boxes),
        cylinders=(*rounds, *_pillars(halls)),
        goal=_place(tour[len(tour) // 2]),
        labels=tuple((*_place(hall), f"hall {k}") for k, hall in enumerate(halls, 1)),
    )


def _corridors(rng: np.random.Generator) -> nx.Graph[Crossing]:
    """Return a lattice from which corridors were left out, as long as all stay joined and none ends blind."""
    graph: nx.Graph[Crossing] = nx.grid_2d_graph(COLUMNS, ROWS)
    edges = sorted(graph.edges)
    wanted = round(KEPT * len(edges))
    for k in rng.permutation(len(edges)).tolist():
        if graph.number_of_edges() <= wanted:
            break
        a, b = edges[k]
        if min(graph.degree[a], graph.degree[b]) > 2:
            graph.remove_edge(a, b)
            if not nx.has_path(graph, a, b):
                graph.add_edge(a, b)
    return graph


def _halls(corridors: nx.Graph[Crossing], rng: np.random.Generator) -> list[Crossing]:
    """Return the crossings where a hall is, one in nine."""
    crossings = sorted(corridors.nodes)
    chosen = rng.choice(len(crossings), len(crossings) // 9, replace=False)
    return [crossings[k] for k in sorted(chosen.tolist())]


def _tour(corridors: nx.Graph[Crossing]) -> list[Crossing]:
    """Return the crossings of a round trip through every corridor, without straight ones: corners only."""
    even = nx.eulerize(corridors)
    start = min(even.nodes)
    tour = [a for a, _ in nx.eulerian_circuit(even, source=start)]
    ring = [tour[-1], *tour, tour[0]]
    triples = zip(ring, ring[1:], ring[2:], strict=False)
    return [b for a, b, c in triples if b == start or (a[0] - b[0], a[1] - b[1]) != (b[0] - c[0], b[1] - c[1])]


def _place(crossing: Crossing) -> Point:
    return PITCH * crossing[0], PITCH * crossing[1]


def _blocks(corridors: nx.Graph[Crossing], halls: Iterable[Crossing]) -> Blocks:
    size = round(PITCH)
    blocks = Blocks((-8.0, -8.0), 1.0, size * (COLUMNS - 1) + 16, size * (ROWS - 1) + 16)
    for a, b in sorted(corridors.edges):
        (x0, y0), (x1, y1) = sorted((_place(a), _place(b)))
        blocks.cut(x0 - HALF, y0 - HALF, x1 + HALF, y1 + HALF)
    for hall in halls:
        x, y = _place(hall)
        blocks.cut(x - HALL, y - HALL, x + HALL, y + HALL)
    return blocks


def _tone(edge: Edge) -> int:
    """Return the tone of a wall: by district, so that neighbouring corridors mostly share theirs."""
    x, y = 0.5 * (edge.a[0] + edge.b[0]), 0.5 * (edge.a[1] + edge.b[1])
    return (int(x // 60) * 2 + int(y // 50) * 3) % len(TONES)


def _pillars(halls: list[Crossing]) -> list[Cylinder]:
    """Return four pillars to a hall."""
    out = []
    for k, hall in enumerate(halls):
        x, y = _place(hall)
        look = Look((0.6 + 0.04 * (k % 3), 0.62, 0.58), "concrete", 900 + k % 5)
        spots = [(x + dx, y + dy) for dx in (-2.8, 2.8) for dy in (-2.8, 2.8)]
        out += [Cylinder(*spot, 0.3, HEIGHT, look, f"pillar {k}.{n}") for n, spot in enumerate(spots)]
    return out
