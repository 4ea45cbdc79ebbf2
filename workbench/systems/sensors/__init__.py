"""Sensors as LeafSystems: truth, sampling and noise kept apart; a sensor a file."""
