"""What a flight is built from, as far as the Settings screen shows it; no Qt."""

import copy
import dataclasses
from dataclasses import dataclass

from workbench.scenario.scenario import Rates, Scenario

RATES = {
    "physics_step": ("Physics step", "Between two steps of the simulation."),
    "control_period": ("Control period", "Between two updates of the controller."),
    "mode_period": ("Mode period", "Between two looks of the flight mode."),
}
"""Label and help of each period."""
FACTORS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
"""A period is one of these times the physics step."""
STEPS = (1 / 4096, 1 / 2048, 1 / 1024, 1 / 512, 1 / 256)
"""Physics steps that are offered; exact in binary, so that no flight drifts from its clock [s]."""


@dataclass(frozen=True)
class FlightSetup:
    """The part of a scenario that can be chosen here.

    Attributes:
        world: name or path.
        sensors: that measure, by name or kind.
        noise: whether they are noisy.
        seed: of noise and turbulence.
        rates: periods [s].
    """

    world: str
    sensors: tuple[str, ...]
    noise: bool
    seed: int
    rates: tuple[float, float, float]

    def scenario(self, base: Scenario) -> Scenario:
        """Return a scenario with this in place of its own."""
        made = copy.deepcopy(base)
        made.world = self.world
        made.sensors = dataclasses.replace(
            made.sensors, use=list(self.sensors), noise=self.noise, seed=self.seed
        )
        made.rates = Rates(*self.rates, record_period=self.rates[1])
        return made


def setup_of(scenario: Scenario, kinds: tuple[str, ...]) -> FlightSetup:
    """Return what a scenario is built from.

    Args:
        scenario: as it is.
        kinds: of sensor that its vehicle has; "all" stands for these.
    """
    use = tuple(scenario.sensors.use)
    rates = scenario.rates
    return FlightSetup(
        world=scenario.world,
        sensors=kinds if "all" in use else use,
        noise=scenario.sensors.noise,
        seed=scenario.sensors.seed,
        rates=(rates.physics_step, rates.control_period, rates.mode_period),
    )


def period_text(period: float) -> str:
    """Return a period in words, as 7.8125 ms (128 Hz)."""
    rate = 1.0 / period
    return f"{1e3 * period:.6g} ms ({rate:.6g} Hz)"
