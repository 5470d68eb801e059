"""Logs: one MCAP file per run, written crash-safe, read whole or truncated, replayed as a robot."""
