"""Sweeps: many candidates flown, their metrics in a table and on a map."""
