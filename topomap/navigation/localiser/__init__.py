"""Where the robot is on its map: several hypotheses, and the probability that none of them holds."""

from topomap.navigation.localiser.localiser import Localiser
from topomap.navigation.localiser.start import ANYWHERE, HERE, Start

__all__ = ["ANYWHERE", "HERE", "Localiser", "Start"]
