"""Instruments: widgets that show one thing, and paint only when it has changed."""
