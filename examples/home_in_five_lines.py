"""Home from one panorama to another: python examples/home_in_five_lines.py HERE.png GOAL.png"""

import math
import sys

from topomap import home, load_panorama

here, goal = load_panorama(sys.argv[1]), load_panorama(sys.argv[2])
way = home(here, goal)
print(
    f"the goal lies {math.degrees(way.bearing):+.1f} degrees to the left; right within 45 with P = {way.confidence:.2f}"
)
