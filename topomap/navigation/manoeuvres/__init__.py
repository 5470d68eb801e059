"""Manoeuvres: short drives to find something out, such as turning to look whether a closure is true."""
