"""Numbers of the flights of a batch."""

from workbench.design.response_metrics import ResponseMetrics, response_metrics
from workbench.design.rollout.rollouts import Rollouts


def rollout_metrics(rollouts: Rollouts, amplitude: float) -> ResponseMetrics:
    """Return the metrics of flown steps, withheld where they mean nothing, see there.

    Args:
        rollouts: kept at every control period if the numbers are to equal those of `fly_step`.
        amplitude: of the command, [m/s] or [rad/s]; not zero.
    """
    found = response_metrics(rollouts.time, rollouts.response, amplitude)
    return found.withheld(rollouts.time[-1], amplitude)
