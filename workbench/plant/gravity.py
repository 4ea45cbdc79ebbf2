"""Gravity and the air, once for plant and law."""

GRAVITY = 9.81
"""Its magnitude [m/s²], as Drake's plant and the paper have it."""
AIR_DENSITY = 1.225
"""Density of air at sea level in the International Standard Atmosphere (ISO 2533) [kg/m³]."""
