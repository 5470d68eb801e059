"""Sweeps: many simulated runs as one table with intervals, and its figure."""
