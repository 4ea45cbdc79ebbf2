"""Rays against the scene: what a lidar would see, to a fraction of a millimetre."""
