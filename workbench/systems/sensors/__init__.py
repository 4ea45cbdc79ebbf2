"""Sensors as LeafSystems, one file each; truth, sampling and noise are separate."""
