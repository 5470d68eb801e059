"""The list of tests that a robot's closures pass, in the order in which it can ask them."""

from __future__ import annotations

from itertools import accumulate, pairwise
from typing import NamedTuple

from topomap.mapping.closures.closure_tests import ClosureTest, Looks
from topomap.mapping.closures.gates import Gate, Supported
from topomap.mapping.closures.sight_tests import BY_SIGHT, BY_SPOT, MOST_APART
from topomap.mapping.closures.spot_tests import AtPlace, Beside, Placed

GATE = 0.95  # share of true closures that odometry lets pass
LIKELY = 0.5  # probability that a closure isn't false by definition, as sight and odometry together have it: of 43
# claims over a park's photographs made larger (x3, x10) none above it was false, of 59 below it 32 were; later runs
# had one above it, by 5 cm


class RobotTests(NamedTuple):
    """The engine's tests in the order in which a robot can ask them: of what is seen, of the measured relative pose,
    of the map for the few that are left and get a node of their own, and of others that agree, for what can't stand
    alone.
    """

    sight: tuple[ClosureTest, ...] = BY_SIGHT
    spot: tuple[ClosureTest, ...] = BY_SPOT
    place: tuple[ClosureTest, ...] = (Looks(), AtPlace(), Beside(MOST_APART), Placed(LIKELY), Gate(GATE))
    company: tuple[ClosureTest, ...] = (Supported(),)

    def all(self) -> tuple[ClosureTest, ...]:
        """Return the list as the engine takes it."""
        return (*self.sight, *self.spot, *self.place, *self.company)

    def stages(self) -> tuple[slice, ...]:
        """Return where the four parts stand in the list."""
        ends = [0, *accumulate(map(len, self))]
        return tuple(slice(*pair) for pair in pairwise(ends))
