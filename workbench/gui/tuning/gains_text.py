"""Sets of gains in few words."""

from collections.abc import Mapping

MOST = 3
"""Names that a short text has."""


def gains_text(gains: Mapping[str, float], base: Mapping[str, float]) -> str:
    """Return what a set of gains has otherwise than another, as kp_pitch 180 instead of 225."""
    other = [name for name, value in gains.items() if name in base and base[name] != value]
    if not other:
        return "gains as now"
    texts = [f"{name} {gains[name]:.4g}" for name in other[:MOST]]
    more = len(other) - MOST
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")
