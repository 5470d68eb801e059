"""Matching of two panoramas: warping, two-view geometry, ring flow, and their numba kernels."""
