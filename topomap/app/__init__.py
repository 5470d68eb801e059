"""The composition root: the one place where stack, simulator and logs meet.

Runs and replays, recordings, benches and sweeps, exports, closures of a log or map, settings, run folders.
"""
