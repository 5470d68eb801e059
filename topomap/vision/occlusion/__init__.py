"""Parts of the robot that stand in its own view: found as it turns, and filled from beside."""
