"""Worlds drawn from a seed, and the blocks, looks and things that they are made of."""
