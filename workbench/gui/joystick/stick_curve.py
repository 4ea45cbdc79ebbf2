"""The curve of a stick: how far it is pushed, and how much that asks for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class StickCurve:
    """Gentle around the middle, and full at the end.

    Attributes:
        sensitivity: share that full stick reaches, 0 .. 1.
        expo: share of the cubic part, 0 .. 1; 0 is a straight line.
        dead_band: share of the way around the middle that asks for nothing, below 1.
    """

    sensitivity: float = 1.0
    expo: float = 0.0
    dead_band: float = 0.0

    def shaped(self, raw: float) -> float:
        """Return what a stick asks for, -1 .. 1.

        What is beyond the dead band is stretched, so that nothing jumps at its edge and full stick
        stays full.

        Args:
            raw: how far it is pushed along one axis, -1 .. 1; what is beyond counts as full.
        """
        way = min(abs(raw), 1.0)
        if way <= self.dead_band:
            return 0.0
        way = (way - self.dead_band) / (1.0 - self.dead_band)
        gentle = (1.0 - self.expo) * way + self.expo * way**3
        return self.sensitivity * (gentle if raw > 0.0 else -gentle)
