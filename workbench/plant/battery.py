"""What feeds the rotors, as far as it is stated."""

from dataclasses import dataclass


@dataclass(frozen=True)
class BatteryPack:
    """A battery as a voltage behind a resistance.

    Attributes:
        capacity: charge of the full battery [C].
        resistance: of cells and leads [Ω].
        open_circuit_voltage: voltage [V] without load over the share of charge, 0 .. 1, rising;
            straight lines lie between the points.
    """

    capacity: float
    resistance: float
    open_circuit_voltage: tuple[tuple[float, float], ...]
