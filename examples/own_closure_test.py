"""A closure test of one's own: nothing may join the two floors of a building, however alike they look."""

from pathlib import Path

import numpy as np

from topomap import TESTS, optimise_graph, read_graph


class SameFloor:
    """The lift is taken at place 60: a claim about places on both sides of it is refused."""

    name, lowers = "same floor", True  # it only speaks against claims, as all behind it do

    def weigh(self, claims, knowledge):
        return np.where((claims.i < 60) == (claims.j < 60), 0.0, -np.inf)  # log likelihood ratios


graph = read_graph(Path(__file__).parent / "graphs" / "block-doubtful.g2o")
for tests in (TESTS, (*TESTS[:2], SameFloor(), *TESTS[2:])):
    found = optimise_graph(graph, tests=tests)
    across = (graph.i < 60) != (graph.j < 60)
    print(f"{found.inlier.sum()} of {len(graph.i)} closures, {found.inlier[across].sum()} of them across the floors")
# a robot's: topomap.build_navigator(config.stack, tests=[SameFloor()])
