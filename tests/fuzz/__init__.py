"""Damaged, crafted and senseless input, made by the hundred: each answer is one line, none is a silent difference."""
