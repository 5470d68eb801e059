"""Nodes as people call them: by number, or by the name of a place."""

from __future__ import annotations

from topomap.core.errors import TopomapError
from topomap.mapping.graph import TopoMap

SHOWN = 12  # names in a message
LONGEST = 64


def find(topo: TopoMap, target: str) -> int:
    """Return the snapshot node of a number or a place. Raises TopomapError, which says what there is."""
    if target in topo.places:
        number = topo.places[target]
    elif target.isascii() and target.isdigit() and len(target) < 10:
        number = int(target)
    else:
        raise TopomapError(f"no place {target!r} on the map; {_known_places(topo)}, and nodes {span(topo)}")
    node = topo.node_named(number)
    if node is None:
        raise TopomapError(f"no node {number} on the map: it has nodes {span(topo)}; {_known_places(topo)}")
    if topo.nodes[node].snapshot is None:
        near = [k for k, other in enumerate(topo.nodes) if other.snapshot is not None]
        nearest = min(near, key=lambda k: topo.length(node, k), default=None)
        instead = "" if nearest is None else f"; the nearest that does is node {topo.names[nearest]}"
        raise TopomapError(f"node {number} holds no view to home to{instead}")
    return node


def name_place(topo: TopoMap, word: str) -> str:
    """Give the node of "NAME=NODE" a name; return the name. Raises TopomapError."""
    name, equals, target = (part.strip() for part in word.partition("="))
    if not equals or not name or not target:
        raise TopomapError(f"--add {word}: expected NAME=NODE, as in desk=12")
    if len(name) > LONGEST or name.isdigit() or not name.isprintable() or set(name) & set(",:=") or name == "unknown":
        raise TopomapError(
            f"--add {word}: a name has at most {LONGEST} letters, none of , : = among them, and is no number"
        )
    topo.places[name] = topo.names[find(topo, target)]
    return name


def forget_place(topo: TopoMap, name: str) -> None:
    """Take a name away. Raises TopomapError."""
    if name not in topo.places:
        raise TopomapError(f"--remove {name}: no such place; {_known_places(topo)}")
    del topo.places[name]


def span(topo: TopoMap) -> str:
    """Return the numbers that the map's nodes have, in words."""
    first, last = min(topo.names), max(topo.names)
    some = "" if last - first + 1 == len(topo.names) else f", {len(topo.names)} of them"
    return f"{first} to {last}{some}"


def _known_places(topo: TopoMap) -> str:
    names = sorted(topo.places)
    more = ", ..." if len(names) > SHOWN else ""
    return f"there are places {', '.join(names[:SHOWN])}{more}" if names else "it has no named places"
