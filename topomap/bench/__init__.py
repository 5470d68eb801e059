"""Benches: homing methods, aligners by place, pose graphs, recordings and sweeps.

`Store` keeps results by content, `Workers` makes the missing ones on all cores.
"""
