"""Gravity, once for plant and law."""

GRAVITY = 9.81
"""Its magnitude [m/s²], as Drake's plant and the paper have it."""
