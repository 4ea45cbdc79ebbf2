"""Names of turbulence, by the wind speed at 20 ft that makes it (MIL-F-8785C, 3.7.2)."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Turbulence:
    """A degree of turbulence.

    Attributes:
        name: of the degree.
        speed: value of the parameter `turbulence` [m/s].
    """

    name: str
    speed: float


TURBULENCES = (
    Turbulence("still", 0.0),
    Turbulence("light", 7.7),
    Turbulence("moderate", 15.4),
    Turbulence("severe", 23.2),
)
