"""When a drone on its back is lost."""

TUMBLING_RATE = 10.0
TUMBLING_SPEED = 20.0
"""One that is tilted over 90 degrees, and turns or moves faster than this, is lost [rad/s, m/s]."""
