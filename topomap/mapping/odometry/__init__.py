"""Odometry: raw increments and their integration, calibration of systematic errors, scan matching."""
