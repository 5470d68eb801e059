"""Somebody else's files as readings, views or closure candidates.

TUC recordings, pose graphs (g2o, TORO), image grids, mirror cameras.
"""
