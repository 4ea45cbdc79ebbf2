"""Fly one vehicle's steps with many gain sets, in compiled code."""

import copy
import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from pydrake.math import RollPitchYaw

from workbench.design.rollout.batch import compiled_flights
from workbench.design.rollout.candidates import make_candidates
from workbench.design.rollout.chunks import run_chunks
from workbench.design.rollout.craft import Schedule, make_craft, varied_craft
from workbench.design.rollout.rollouts import Rollouts
from workbench.design.step_response import AXES, EDGE, START_HEIGHT, check_duration
from workbench.errors import WorkbenchError, unknown_name
from workbench.gains import flight_gains
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario import Rates, Scenario, check_scenario
from workbench.systems.cascade import Guidance, Reference

THREADS = 2
"""As many as the machines that this is made for have cores to spare."""


class RolloutEngine:
    """Flies steps as `fly_step` does, from hover in the same air, thousands of them a second.

    It is the same law around a rigid body of its own, so there is no ground to stand on, no
    obstacle, no battery and no sensor. It has no state: threads may share it.

    Args:
        vehicle: as the law knows it.
        rates: periods of physics and control; those of a scenario that says nothing without.
        variation: how what flies differs from the vehicle.
        seed: of the turbulence, where parameters ask for any; as a scenario's.
        threads: that fly at a time; 1 flies in the caller's.

    Raises:
        WorkbenchError: if rates or variation cannot be flown.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        rates: Rates | None = None,
        variation: Variation | None = None,
        *,
        seed: int = 0,
        threads: int = THREADS,
    ) -> None:
        self.vehicle = vehicle
        rates = rates or Rates()
        self.rates = dataclasses.replace(rates, record_period=rates.control_period)
        check_scenario(Scenario(rates=self.rates))
        self.gains = flight_gains(vehicle)
        self._threads = max(1, min(threads, len(os.sched_getaffinity(0))))
        self._believed = make_craft(vehicle, self.rates.control_period, seed)
        self._start = _hover(vehicle)
        self._vary(variation or Variation())

    def varied(self, variation: Variation) -> "RolloutEngine":
        """Return an engine for the same vehicle with another variation; quicker than a new one.

        Raises:
            WorkbenchError: if the variation cannot be flown.
        """
        other = copy.copy(self)
        other._vary(variation)
        return other

    def fly(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        axis: str,
        amplitude: float,
        *,
        duration: float = 3.0,
        stride: int = 1,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Rollouts:
        """Fly a step with every gain set.

        Values are taken as they are, also those beyond their parameters' limits; where a gain set
        limits speed to less than the amplitude, the law cuts the command.

        Args:
            gains: parameter values by name of each of N candidates, or an array (N, 18) with
                columns as `cascade.Gains`. What is not named has the vehicle's own value.
            axis: x, y, z or yaw.
            amplitude: of the command, [m/s] or [rad/s].
            duration: flown after the edge [s].
            stride: the first and every stride-th control period after it are kept.
            progress: called with the flown share, 0 .. 1.
            stop: asked every few flights; when it returns true, those flown so far are returned.

        Raises:
            WorkbenchError: if that makes no step, or the gains are not what they should be.
        """
        _check(axis, amplitude, duration, stride)
        candidates = make_candidates(gains, self.gains, len(self.vehicle.rotors))
        schedule = self._schedule(duration, stride)
        time = np.arange(schedule.edge, schedule.end + 1, stride) * schedule.period - EDGE
        count = len(candidates.gains)
        velocity = np.full((count, len(time), 3), np.nan)
        spin = np.full((count, len(time), 3), np.nan)
        peak_use, lost_at = np.zeros(count), np.full(count, -1)
        reference, guidance = np.zeros(len(Reference._fields)), _hold()
        reference[AXES.index(axis)] = amplitude

        def work(first: int, last: int) -> None:
            these = slice(first, last)
            compiled_flights(
                candidates.gains[these],
                candidates.shares[these],
                candidates.air[these],
                reference,
                guidance,
                self._start,
                self._craft,
                schedule,
                velocity[these],
                spin[these],
                peak_use[these],
                lost_at[these],
            )

        done = run_chunks(work, count, self._threads, progress, stop)
        after = np.maximum(0.0, (lost_at - schedule.edge) * schedule.period)
        return Rollouts(
            axis=axis,
            time=time,
            velocity_W=velocity[:done],
            angular_velocity_W=spin[:done],
            peak_rotor_use=peak_use[:done],
            diverged_at=np.where(lost_at < 0, np.nan, after)[:done],
        )

    def _schedule(self, duration: float, stride: int) -> Schedule:
        """Return when things happen; a command comes between physics steps, see `Session`."""
        step = self.rates.physics_step
        steps = round(self.rates.control_period / step)
        edge = math.ceil(EDGE / step - 1e-6)
        return Schedule(
            step=step,
            period=self.rates.control_period,
            steps=steps,
            edge=-(-edge // steps),
            end=math.floor((EDGE + duration) / step + 1e-6) // steps,
            stride=stride,
            delay=self.variation.control_delay,
        )

    def _vary(self, variation: Variation) -> None:
        """Let what flies differ; the law goes on believing in the vehicle."""
        variation.check()
        self.variation = dataclasses.replace(variation)
        period = self.rates.control_period
        self._craft = varied_craft(self._believed, self.vehicle, period, variation)


def _check(axis: str, amplitude: float, duration: float, stride: int) -> None:
    """Refuse what makes no step."""
    if axis not in AXES:
        raise unknown_name("axis", axis, AXES)
    check_duration(duration)
    if not 0.0 < abs(amplitude) < math.inf:
        raise WorkbenchError(f"the amplitude is {amplitude:g}: give it a finite number, and not 0")
    if stride < 1 or int(stride) != stride:
        raise WorkbenchError(f"the stride is {stride:g}: give it a whole number, 1 or more")


def _hover(vehicle: Vehicle) -> np.ndarray:
    """Return the plant's state (13) of a vehicle that hovers where steps begin."""
    attitude = RollPitchYaw(np.array(thrust_frame(vehicle).roll_pitch_yaw([0.0, 0.0, 0.0])))
    q_WB = attitude.ToRotationMatrix().ToQuaternion().wxyz()
    return np.array([*q_WB, 0.0, 0.0, START_HEIGHT, *[0.0] * 6])


def _hold() -> np.ndarray:
    """Return guidance (22) that holds the start until a pilot steers, see `flight_mode`."""
    return np.array(Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, START_HEIGHT), dtype=float)
