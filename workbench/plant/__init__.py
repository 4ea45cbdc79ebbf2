"""What flies: a drone description becomes a Drake plant and a frozen `Vehicle` record.

Frames, said once for the whole project: the world W is east-north-up with z up; the body B is
the description's base link, x forward, y left, z up. SI units and radians throughout.
"""
