"""Compass heading of a drone's nose; plain mathematics.

The world is east-north-up: yaw is 0 when the nose points east, and increases towards north. A
compass shows degrees from north, clockwise seen from above. So heading = 90° - yaw.
"""

import math

COMPASS_POINTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
"""Points of the compass, every 45° clockwise from north."""


def heading_of(yaw: float) -> float:
    """Return the heading [degrees], 0 up to below 360, of a yaw [rad]."""
    heading = math.fmod(90.0 - math.degrees(yaw), 360.0)
    heading = heading + 360.0 if heading < 0.0 else heading
    return 0.0 if heading >= 360.0 else heading


def direction_of(east: float, north: float) -> float:
    """Return the heading [degrees] of a horizontal vector, 0 if it has no length."""
    return heading_of(math.atan2(north, east)) if east or north else 0.0


def compass_point(heading: float) -> str:
    """Return the nearest of the eight points of the compass."""
    return COMPASS_POINTS[round(heading / 45.0) % len(COMPASS_POINTS)]


def mark_text(degrees: int) -> str:
    """Return the text at a mark of the tape."""
    degrees %= 360
    return COMPASS_POINTS[degrees // 45] if degrees % 45 == 0 else f"{degrees:03d}"
