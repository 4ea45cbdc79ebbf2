"""Instruments: widgets that show one thing, and repaint only when it has changed."""
