"""logs: MCAP logs of runs, written, read, repaired and replayed."""
