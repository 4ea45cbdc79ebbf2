"""The vehicle: from a drone description to a Drake plant and a frozen `Vehicle` record.

Frames of the whole project: the world W has x east, y north, z up. The body B is the base link of
the description, with x forward, y left, z up. All units are SI, angles in radians.
"""
