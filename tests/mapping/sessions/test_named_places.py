"""Nodes by number or name: what isn't there is answered with what is."""

from __future__ import annotations

import pytest
from maps import STEP_NS, square

from topomap.core.errors import TopomapError
from topomap.mapping.sessions.places import find, forget_place, name_place


def test_a_node_is_found_by_its_number_and_by_its_name() -> None:
    topo = square()
    topo.names = [10 + k for k in range(17)]
    assert name_place(topo, "desk = 12") == "desk"
    assert find(topo, "desk") == find(topo, "12") == 2
    forget_place(topo, "desk")
    assert topo.places == {}


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ("kitchen", "no place 'kitchen' on the map; there are places desk, and nodes 0 to 17"),
        ("18", "no node 18 on the map: it has nodes 0 to 17; there are places desk"),
        ("-1", "no place '-1'"),
        ("17", "node 17 holds no view to home to; the nearest that does is node 1"),
    ],
)
def test_what_is_not_there_is_answered_with_what_is(target: str, said: str) -> None:
    topo = square()
    topo.insert(7 * STEP_NS)
    name_place(topo, "desk=3")
    with pytest.raises(TopomapError, match=said) as error:
        find(topo, target)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "word", ["desk", "=3", "desk=", "12=3", "a,b=3", "a:b=3", "unknown=3", "x" * 65 + "=3", "a\nb=3"]
)
def test_a_name_that_a_mission_could_not_read_is_refused(word: str) -> None:
    with pytest.raises(TopomapError, match="--add"):
        name_place(square(), word)


def test_only_a_place_that_there_is_can_be_taken_away() -> None:
    with pytest.raises(TopomapError, match="no such place; it has no named places"):
        forget_place(square(), "desk")
