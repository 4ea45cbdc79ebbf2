"""A flight in compiled code, from the Context and back into it; `flight_loop` defines the order.

Before and after, Drake's systems have every number. So reading, setting, drawing and forking work
as if the Simulator had flown, and the Simulator continues where compiled code cannot.
"""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context, System

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.flight_mode import ModeState, Settings, Situation, guidance, next_state
from workbench.diagram.core import COMMAND_DELAY, STATE_DELAY
from workbench.diagram.workbench import Workbench
from workbench.dynamics.vehicle_step import FULL, ROW, static_thrust
from workbench.scenario.scenario import Rates, Scenario
from workbench.systems.battery import PERIOD
from workbench.systems.flight_computer import COMMANDS, FILTERED
from workbench.systems.flight_computer import MEMORY as REMEMBERED
from workbench.systems.flight_loop import REFUSED, compiled_loop
from workbench.systems.vehicle_dynamics import (
    AIR,
    AWAY,
    BODY,
    BROKEN,
    DONE,
    MEMORY,
    ROTORS,
    SPEEDS,
)


def why_not_compiled(scenario: Scenario, bench: Workbench) -> str:
    """Return why compiled code does not support a flight, "" if it does."""
    controller = bench.controller
    step = scenario.rates.physics_step
    periods = (scenario.rates.mode_period, PERIOD)
    late = any(map(bench.diagram.HasSubsystemNamed, (STATE_DELAY, COMMAND_DELAY)))
    for reason, there in (
        (f"the estimator {scenario.estimator}", bench.navigation is not None),
        (f"the sensors {', '.join(scenario.sensors.use)}", bool(bench.sensing.mounted)),
        (f"the obstacles of {scenario.world}", bench.obstacles is not None),
        ("pictures in Meshcat", bench.visualizer is not None),
        ("clients", bench.telemetry is not None),
        ("a figure of eight", scenario.figure_eight is not None),
        ("delays of sensing and commands", late),
        (f"the controller {controller.name}, a system of Drake's", not controller.compiles),
        (f"the controller {controller.name}, a program", controller.program is not None),
        (f"a physics step of {step:g} s", not all((p / step).is_integer() for p in periods)),
    ):
        if there:
            return reason
    return ""


def is_quick(controller: Controller) -> bool:
    """Return whether compiled code of a law's flights exists, or is made once on a machine.

    A user's own law and a schedule change often. The diagram flies them sooner, as it compiles the
    law and not the whole flight.
    """
    once = controller.shipped and controller.schedule is None
    return once or compiled_loop(controller).is_made


class CompiledFlight:
    """Advances the numbers of a diagram's Context.

    Args:
        bench: a diagram that `why_not_compiled` accepts.
        rates: rates of the flight.
    """

    def __init__(self, bench: Workbench, rates: Rates) -> None:
        self._bench = bench
        self._loop = compiled_loop(bench.controller)
        self._width = max(place.stop for place in bench.recorder.places.values())
        step = rates.physics_step
        self._step, self._record_period = step, rates.record_period
        self._control, self._modes, self._record, self._discharges = (
            round(period / step)
            for period in (
                rates.control_period,
                rates.mode_period,
                rates.record_period,
                PERIOD,
            )
        )

    def fly(
        self,
        root: Context,
        first: int,
        last: int,
        keep: Callable[[np.ndarray, np.ndarray], None],
    ) -> int:
        """Fly from one step up to just before another one, as far as possible.

        Args:
            root: the diagram's Context at the time of the first step; it is changed, with its time.
            first: number of the first step.
            last: step before which the flight ends.
            keep: takes the times [s] (N) and rows (N, sizes) to record.

        Returns:
            The number of the next step. It is less than `last` if the vehicle may touch the ground
            in that step, or the law fails in it; the diagram can continue there, and says why.

        Raises:
            RuntimeError: if forces or motion are not finite, as in the diagram.
        """
        flown = _Numbers(self._bench, root)
        dynamics, number, came = self._bench.airframe.dynamics, first, DONE
        places = self._bench.recorder.places
        sizes = last // self._record - first // self._record, self._width
        recorded = np.empty(sizes)
        while number < last and came not in (BROKEN, REFUSED):
            if flown.memory[AWAY] < 1.0 and not dynamics.find_free(flown.state, flown.memory):
                break
            mode, guide, charge = flown.mode, flown.guide, flown.charge
            if number % self._modes == 0:
                mode, guide = flown.next_mode(number * self._step)
            if number % self._discharges == 0:
                charge = flown.next_charge()
            until = min(last, _multiple(number, self._modes), _multiple(number, self._discharges))
            row = number // self._record - first // self._record
            rows = recorded[row : until // self._record - first // self._record]
            rows[:, places["reference"]] = flown.reference
            rows[:, places["mode"]] = mode
            rows[:, places["charge"]] = charge
            before = number
            try:
                number, came = self._loop(
                    number,
                    until,
                    self._control,
                    self._record,
                    flown.reference,
                    np.array([flown.guide, guide]),
                    np.array([flown.supply_at(flown.charge), flown.supply_at(charge)]),
                    flown.law,
                    flown.values,
                    flown.constants,
                    dynamics.above_ground,
                    flown.state,
                    flown.memory,
                    flown.commands,
                    flown.filtered,
                    flown.remembered,
                    rows,
                )
            except WorkbenchError:
                raise
            except Exception:  # of the law, somewhere in these steps; nothing is written yet
                return first
            if number > before:
                flown.mode, flown.guide, flown.charge = mode, guide, charge
        flown.write()
        root.SetTime(number * self._step)
        marks = range(first // self._record + 1, number // self._record + 1)
        if marks:
            keep(np.array(marks) * self._record_period, recorded[: len(marks)])
        if came == BROKEN:
            raise RuntimeError("forces or motion of the vehicle are not finite")
        return number


class _Numbers:
    """State of a flight's systems in a Context, as plain numbers.

    Attributes:
        state: state of the body (13).
        memory: state of the vehicle, see `vehicle_dynamics.MEMORY`.
        commands: commanded rotor speeds (n) [rad/s].
        filtered: state of the stages before the law.
        remembered: state of the law.
        reference: the pilot's command (8).
        mode: flight mode.
        guide: guidance for the law (22).
        charge: charge of the battery, 0 .. 1.
        law: further arguments of a control update, see `FlightComputer.known`.
        values: numeric parameter 0 of the vehicle.
        constants: see `vehicle_dynamics.advance`.
    """

    def __init__(self, bench: Workbench, root: Context) -> None:
        self._bench = bench
        self._root = root
        self._battery = bench.diagram.GetSubsystemByName("battery")
        dynamics, computer = self._of(bench.airframe.dynamics), self._of(bench.computer)
        self.state = dynamics.get_discrete_state(BODY).CopyToVector()
        self.memory = dynamics.get_discrete_state(MEMORY).CopyToVector()
        self.values = dynamics.get_numeric_parameter(AIR).CopyToVector()
        self.constants = bench.airframe.dynamics.step_constants()
        self.commands = computer.get_discrete_state(COMMANDS).CopyToVector()
        self.filtered = computer.get_discrete_state(FILTERED).CopyToVector()
        self.remembered = np.empty(0)
        if bench.controller.memory:
            self.remembered = computer.get_discrete_state(REMEMBERED).CopyToVector()
        self.law = bench.computer.known(computer)
        modes, wish = bench.modes, bench.pilot.wish(self._of(bench.pilot))
        context = self._of(modes)
        self.mode = ModeState(*context.get_discrete_state(modes.mode_index).CopyToVector().tolist())
        self.guide = context.get_discrete_state(modes.guidance_index).CopyToVector()
        self._settings = Settings(*context.get_numeric_parameter(0).CopyToVector().tolist())
        self._wish = wish
        self.reference = np.array(wish.reference)
        battery = self._of(self._battery)
        self.charge = float(battery.get_discrete_state(0).CopyToVector()[0])
        self._duration, self._compensation = battery.get_numeric_parameter(0).CopyToVector()

    def _of(self, system: System) -> Context:
        """Return a system's Context."""
        return system.GetMyMutableContextFromRoot(self._root)

    def next_mode(self, time: float) -> tuple[ModeState, np.ndarray]:
        """Return the mode and its guidance after an update at a time [s]."""
        state = self.state.tolist()
        now = Situation(
            time=time,
            p_WB=state[4:7],
            v_WB=state[10:13],
            reference=self._wish.reference,
            request=int(self._wish.request),
            serial=self._wish.serial,
            height=self._wish.height,
            charge=self.charge,
            standing_height=self._bench.vehicle.ground_clearance,
        )
        mode = next_state(self.mode, now, self._settings)
        return mode, np.array(guidance(mode, now.p_WB, self._settings))

    def next_charge(self) -> float:
        """Return the charge after an update."""
        n = len(self.commands)
        speeds, shares = self.memory[SPEEDS : SPEEDS + n], self.memory[SPEEDS + n :]
        rotors = self.constants[ROTORS:].reshape(n, ROW)
        thrusts = static_thrust(speeds, shares, rotors.T).tolist()
        after: float = self._battery.charge_after(self.charge, thrusts, self._duration)
        return after

    def supply_at(self, charge: float) -> list[float]:
        """Return the battery's supply at a charge (4)."""
        if not self._bench.airframe.dynamics.HasInputPort("supply"):
            return list(FULL)
        supply: list[float] = self._battery.supply_at(charge, self._duration, self._compensation)
        return supply

    def write(self) -> None:
        """Write the numbers to the Context."""
        dynamics, computer = self._of(self._bench.airframe.dynamics), self._of(self._bench.computer)
        dynamics.SetDiscreteState(BODY, self.state)
        dynamics.SetDiscreteState(MEMORY, self.memory)
        computer.SetDiscreteState(COMMANDS, self.commands)
        computer.SetDiscreteState(FILTERED, self.filtered)
        if self.remembered.size:
            computer.SetDiscreteState(REMEMBERED, self.remembered)
        modes = self._of(self._bench.modes)
        modes.SetDiscreteState(self._bench.modes.mode_index, list(self.mode))
        modes.SetDiscreteState(self._bench.modes.guidance_index, self.guide)
        self._of(self._battery).SetDiscreteState([self.charge])


def _multiple(number: int, of: int) -> int:
    """Return the first multiple larger than a number."""
    return (number // of + 1) * of
