"""sim2d: a 2D world with a ray-cast panorama sensor and drifting odometry."""
