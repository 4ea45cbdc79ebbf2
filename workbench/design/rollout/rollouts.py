"""Results of flights in compiled code: responses, measured numbers and motions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.step_metrics import StepMetrics, step_metrics
from workbench.scenario.axes import AXIS_NAMES


@dataclass(frozen=True)
class Rollouts:
    """N flown steps at the same M times.

    A candidate that is lost has NaN from then on; the others fly on. It is lost when a number is
    no longer finite, when it comes down to the ground, or when it is tilted over 90 degrees and
    then turns faster than 10 rad/s or moves faster than 20 m/s.

    Attributes:
        axis: x, y, z or yaw, on which the command steps.
        time: (M) from the command's edge on [s].
        velocity_W: (N, M, 3) of the base link's origin in W [m/s].
        angular_velocity_W: (N, M, 3) in W [rad/s].
        peak_rotor_use: (N) largest share of its speed limit at which any rotor ran, 0 .. 1.
        diverged_at: (N) when it was lost, from the edge on [s]: 0 if already in the hover before,
            NaN if it flew to the end.
        before: (N) velocity or yaw rate at the edge of a step from a steady drift in wind, else 0.
        unsteady: why the air leaves a step without a steady state, by the candidate's number.
    """

    axis: str
    time: np.ndarray
    velocity_W: np.ndarray
    angular_velocity_W: np.ndarray
    peak_rotor_use: np.ndarray
    diverged_at: np.ndarray
    before: np.ndarray
    unsteady: Mapping[int, str]

    def __repr__(self) -> str:
        return f"<Rollouts of {len(self)} steps along {self.axis}: {len(self.time)} samples each>"

    def __len__(self) -> int:
        return len(self.diverged_at)

    @property
    def response(self) -> np.ndarray:
        """Velocity [m/s] or yaw rate [rad/s] on the commanded axis, from `before` on (N, M)."""
        if self.axis == "yaw":
            return self.angular_velocity_W[:, :, 2] - self.before[:, None]
        return self.velocity_W[:, :, AXIS_NAMES.index(self.axis)] - self.before[:, None]

    def decay_times(self, known: Sequence[float] | float = 0.0) -> np.ndarray:
        """Return the known decay times (N) [s], infinite for steps without a steady state.

        `step_metrics` withholds the numbers of those.
        """
        decay = np.full(len(self), known, dtype=float)
        decay[list(self.unsteady)] = np.inf
        return decay


@dataclass(frozen=True)
class MeasuredSteps:
    """Metrics of N steps whose curves were not kept.

    Attributes:
        metrics: (N) each, withheld where a step did not begin at rest or has not settled; they
            mean nothing for a candidate that was lost.
        diverged_at: (N) see `Rollouts`.
    """

    metrics: StepMetrics
    diverged_at: np.ndarray

    def __len__(self) -> int:
        return len(self.diverged_at)


@dataclass(frozen=True)
class Flights:
    """N flights from any start.

    Attributes:
        time: (M) from the start on [s].
        states: (N, M, 13) of the body, see `record.flight_dtype`; NaN from when it was lost on.
        peak_rotor_use: (N) see `Rollouts`.
        diverged_at: (N) see `Rollouts`.
    """

    time: np.ndarray
    states: np.ndarray
    peak_rotor_use: np.ndarray
    diverged_at: np.ndarray

    def __len__(self) -> int:
        return len(self.diverged_at)

    @property
    def velocity_W(self) -> np.ndarray:
        """Of the base link's origin (N, M, 3) [m/s]."""
        return self.states[:, :, 10:13]

    @property
    def angular_velocity_W(self) -> np.ndarray:
        """(N, M, 3) [rad/s]."""
        return self.states[:, :, 7:10]


def rollout_metrics(rollouts: Rollouts, amplitude: float) -> StepMetrics:
    """Return the metrics of flown steps, (N) each.

    Args:
        rollouts: kept at every control period if the numbers are to equal those of `fly_step`.
        amplitude: of the command, [m/s] or [rad/s]; not zero.
    """
    return step_metrics(
        rollouts.time,
        rollouts.response,
        amplitude,
        decay=rollouts.decay_times(),
        peak_rotor_use=rollouts.peak_rotor_use,
    )
