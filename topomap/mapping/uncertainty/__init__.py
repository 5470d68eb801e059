"""How well one place is known from another.

Odometry chain (whole or growing), paths over closures and their covariance, agreement, reachability.
"""
