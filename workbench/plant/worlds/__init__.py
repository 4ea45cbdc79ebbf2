"""Worlds: static and moving obstacles around the drone, from YAML and added formats."""
