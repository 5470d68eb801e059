"""What a robot's driver does wrong, told before the first drive: `check_robot`."""

from topomap.navigation.robot_check.check import check_robot
from topomap.navigation.robot_check.finding import Finding

__all__ = ["Finding", "check_robot"]
