"""Sets of gains in few words."""

from collections.abc import Mapping

MOST = 3
"""Names that a short text has."""


def gains_text(
    gains: Mapping[str, float],
    base: Mapping[str, float],
    *,
    same: str = "gains as now",
    most: int = MOST,
) -> str:
    """Return what a set of gains has otherwise than another, as kp_pitch 180, in few words.

    Args:
        gains: by name.
        base: with which they are compared, where it has the same names.
        same: what is said where none is other.
        most: so many gains are named.
    """
    other = [name for name, value in gains.items() if name in base and base[name] != value]
    if not other:
        return same
    texts = [f"{name} {gains[name]:.4g}" for name in other[:most]]
    more = len(other) - most
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def gains_list(gains: Mapping[str, float], base: Mapping[str, float]) -> tuple[str, ...]:
    """Return a line for each gain that a set has otherwise than another: both values."""
    return tuple(
        f"{name} {value:.6g} instead of {base[name]:.6g}"
        for name, value in gains.items()
        if name in base and base[name] != value
    )
