"""Round numbers, and numbers as they are written."""

import math


def round_step(span: float, count: int) -> float:
    """Return 1, 2 or 5 times a power of ten that divides a span into about so many parts."""
    if not math.isfinite(span) or span <= 0.0:
        return 1.0
    rough = span / max(1, count)
    power = 10.0 ** math.floor(math.log10(rough))
    return next(
        factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= 0.999 * rough
    )


def decimals_for_step(step: float) -> int:
    """Return how many decimals tell multiples of a step apart."""
    return max(0, -math.floor(math.log10(step) + 1e-6)) if step > 0.0 else 0


def number_text(value: float, decimals: int) -> str:
    """Return a number with a true minus sign, and none before a zero; a dash for what is none."""
    if not math.isfinite(value):
        return "–"
    if abs(value) >= 1e6:
        return f"{value:.3g}".replace("-", "\N{MINUS SIGN}")
    text = f"{value:.{decimals}f}"
    if float(text) == 0.0:
        text = text.removeprefix("-")
    return text.replace("-", "\N{MINUS SIGN}")


def decimals_for(span: float) -> int:
    """Return how many decimals tell a hundredth or so of a span."""
    if not math.isfinite(span) or span <= 0.0:
        return 2
    return min(6, max(0, 2 - math.floor(math.log10(span))))
