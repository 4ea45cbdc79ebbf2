"""Readers of logs: of our own, and the choice among those that packages add."""
