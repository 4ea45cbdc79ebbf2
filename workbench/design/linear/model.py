"""A linear model with named signals, of the closed loop and of open loops."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller
from workbench.control.loop import Loop
from workbench.design.linear.operating_point import OperatingPoint

if TYPE_CHECKING:
    import control

FILTER_PARAMETERS = ("gyro_lowpass", "gyro_notch", "setpoint_lowpass", "derivative_lowpass")
"""Parameters that switch filters of the flight computer on."""


@dataclass(frozen=True)
class ModelSignal:
    """Name and unit of a state, an input or an output."""

    name: str
    unit: str


@dataclass(frozen=True)
class Matrices:
    """A linear system as matrices and names, with the same content as a `control.StateSpace`.

    Attributes:
        A: (m, m).
        B: (m, k).
        C: (l, m).
        D: (l, k).
        dt: period of a sampled system [s]; 0 for a continuous one.
        state_labels: (m) names; empty if states are combinations without names.
        input_labels, output_labels: (k) and (l) names.
        name: of the system.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    dt: float
    state_labels: tuple[str, ...]
    input_labels: tuple[str, ...]
    output_labels: tuple[str, ...]
    name: str

    @property
    def poles(self) -> np.ndarray:
        """Eigenvalues of A (m)."""
        return np.linalg.eigvals(self.A).astype(complex)

    def state_space(self) -> "control.StateSpace":
        """Return the system as a `control.StateSpace`."""
        import control  # takes a second to load

        return control.ss(
            self.A,
            self.B,
            self.C,
            self.D,
            self.dt,
            inputs=list(self.input_labels),
            outputs=list(self.output_labels),
            states=list(self.state_labels) or None,
            name=self.name,
        )


@dataclass(frozen=True)
class Trim:
    """A trim: a steady flight, or an instant of a flight.

    Attributes:
        point: the operating point.
        q_WB: orientation, a unit quaternion w, x, y, z.
        p_WB: position [m], any one far from ground and ceiling.
        v_WB: velocity in W [m/s].
        w_WB: angular velocity in W [rad/s].
        vdot_WB: acceleration in W [m/s²].
        speeds: of the rotors (n) [rad/s].
        commands: commanded speeds (n) [rad/s], larger if the battery voltage drops under load.
        reference: velocity [m/s] and yaw rate [rad/s] commanded by the pilot (4).
        p_WB_setpoint: position to hold (3) [m], beside p_WB by what the law leaves.
        memory: of the law (k).
        joints: positions of the joints, at rest (j) [rad or m].
    """

    point: OperatingPoint
    q_WB: np.ndarray
    p_WB: np.ndarray
    v_WB: np.ndarray
    w_WB: np.ndarray
    vdot_WB: np.ndarray
    speeds: np.ndarray
    commands: np.ndarray
    reference: np.ndarray
    p_WB_setpoint: np.ndarray
    memory: np.ndarray
    joints: np.ndarray

    @property
    def state(self) -> np.ndarray:
        """The state of the body (13)."""
        return np.concatenate([self.q_WB, self.p_WB, self.w_WB, self.v_WB])

    @property
    def tilt(self) -> float:
        """Angle between body z and world z [rad]."""
        w, x, y, z = self.q_WB
        return float(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)))


@dataclass(frozen=True)
class LinearModel:
    """The linear model of the closed loop at a trim, in the axes of the heading.

    Attributes:
        A: (m, m).
        input_matrix: (m, k).
        output_matrix: (l, m).
        feedthrough: (l, k).
        period: of the sampled model [s]; 0 for the continuous one.
        states: m signals.
        inputs: k signals.
        outputs: l signals.
        trim: of the model.
        controller: with its loops; None for a vehicle alone.
    """

    A: np.ndarray
    input_matrix: np.ndarray
    output_matrix: np.ndarray
    feedthrough: np.ndarray
    period: float
    states: tuple[ModelSignal, ...]
    inputs: tuple[ModelSignal, ...]
    outputs: tuple[ModelSignal, ...]
    trim: Trim
    controller: Controller | None = None

    @property
    def loops(self) -> tuple[Loop, ...]:
        """Loops that can be opened."""
        return self.controller.loops if self.controller else ()

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(signal.name for signal in self.states)

    def B(self, names: Sequence[str]) -> np.ndarray:
        """Return the columns of some inputs, (m, names)."""
        return self.input_matrix[:, self._places(names, self._inputs, "input")]

    def C(self, names: Sequence[str]) -> np.ndarray:
        """Return the rows of some outputs, (names, m)."""
        return self.output_matrix[self._places(names, self._outputs, "output")]

    def D(self, outputs: Sequence[str], inputs: Sequence[str]) -> np.ndarray:
        """Return the feedthrough, (outputs, inputs)."""
        rows = self.feedthrough[self._places(outputs, self._outputs, "output")]
        return rows[:, self._places(inputs, self._inputs, "input")]

    def cut(self, point: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the loop opened at a loop point, as A (m, m), b (m) and c (m).

        With negative feedback the open loop is L = -c (zI - A)⁻¹ b, and 1 + L is the ratio of the
        characteristic polynomials of the closed and the open loop.
        """
        b, c = self.B([point])[:, 0], self.C([point])[0]
        return self.A - np.outer(b, c), b, c

    def opened(self, points: Sequence[str]) -> "LinearModel":
        """Return the model with its loops opened at several loop points.

        Signals that arrive there are still outputs, and injections are still passed on.
        """
        B, C = self.B(points), self.C(points)
        rows = [self._outputs[point] for point in points]
        D_out, D_in = self.D(list(self._outputs), points), self.feedthrough[rows]
        return replace(
            self,
            A=self.A - B @ C,
            input_matrix=self.input_matrix - B @ D_in,
            output_matrix=self.output_matrix - D_out @ C,
            feedthrough=self.feedthrough - D_out @ D_in,
        )

    def lean(self, removable: Collection[str]) -> "LinearModel":
        """Return the model without removable states that nothing depends on.

        Args:
            removable: names of states that may be removed.
        """
        read: np.ndarray = np.abs(np.vstack([self.A, self.output_matrix])).max(axis=0) > 0.0
        lasting = [signal.name not in removable for signal in self.states]
        kept = np.flatnonzero(read | lasting)
        return replace(
            self,
            A=self.A[np.ix_(kept, kept)],
            input_matrix=self.input_matrix[kept],
            output_matrix=self.output_matrix[:, kept],
            states=tuple(self.states[place] for place in kept),
        )

    def open_loop(self, point: str) -> "control.StateSpace":
        """Return the open loop L at a loop point as a `control.StateSpace`."""
        return self.loop_matrices(point).state_space()

    def loop_matrices(self, point: str) -> Matrices:
        """Return the open loop L at a loop point."""
        A, b, c = self.cut(point)
        return self._named(A, b[:, None], -c[None, :], np.zeros((1, 1)), [point], [point])

    def state_space(self, inputs: Sequence[str], outputs: Sequence[str]) -> "control.StateSpace":
        """Return the closed loop between selected signals as a `control.StateSpace`."""
        return self.matrices(inputs, outputs).state_space()

    def matrices(self, inputs: Sequence[str], outputs: Sequence[str]) -> Matrices:
        """Return the closed loop between selected signals."""
        return self._named(
            self.A, self.B(inputs), self.C(outputs), self.D(outputs, inputs), inputs, outputs
        )

    def _named(
        self,
        A: np.ndarray,
        B: np.ndarray,
        C: np.ndarray,
        D: np.ndarray,
        inputs: Sequence[str],
        outputs: Sequence[str],
    ) -> Matrices:
        names = self.state_names, tuple(inputs), tuple(outputs)
        return Matrices(A, B, C, D, self.period, *names, self.trim.point.label)

    @cached_property
    def _inputs(self) -> dict[str, int]:
        return {signal.name: place for place, signal in enumerate(self.inputs)}

    @cached_property
    def _outputs(self) -> dict[str, int]:
        return {signal.name: place for place, signal in enumerate(self.outputs)}

    def _places(self, names: Sequence[str], known: dict[str, int], what: str) -> list[int]:
        if isinstance(names, str):
            raise WorkbenchError(f"'{names}' is a name: give a list of names, as ['{names}']")
        for name in names:
            if name not in known:
                raise unknown_name(what, name, list(known))
        return [known[name] for name in names]


def frequency_response(
    model: LinearModel, frequency: np.ndarray, outputs: Sequence[str], inputs: Sequence[str]
) -> np.ndarray:
    """Return the response (F, outputs, inputs) of a closed loop at frequencies (F) [rad/s]."""
    point = 1j * frequency[:, None, None]
    if model.period:
        point = np.exp(point * model.period)
    B, C, D = model.B(inputs), model.C(outputs), model.D(outputs, inputs)
    states = np.linalg.solve(point * np.eye(len(model.A)) - model.A, B[None].astype(complex))
    return np.asarray(C @ states + D)


NOMINAL_ERRORS = tuple(
    (f"estimated_{name}_{axis}", unit)
    for name, unit in (
        ("angle", "rad"),
        ("p", "m"),
        ("v", "m/s"),
        ("gyro_bias", "rad/s"),
        ("accel_bias", "m/s^2"),
    )
    for axis in "xyz"
)
"""Errors of the nominal state of every estimator, with units."""
MEASURED_SIGNALS = (
    *((f"gps_p_{axis}", "m") for axis in "xyz"),
    *((f"gps_v_{axis}", "m/s") for axis in "xyz"),
    ("barometer_height", "m"),
    ("magnetometer_heading", "rad"),
    ("range_finder_distance", "m"),
)
"""Measurements of sensors other than the IMU, with units."""


def vector_signals(name: str, unit: str) -> tuple[ModelSignal, ...]:
    """Return the signals of a vector, with the axis as suffix of each name."""
    return tuple(ModelSignal(f"{name}_{axis}", unit) for axis in "xyz")


def motion_signals(prefix: str = "") -> tuple[ModelSignal, ...]:
    """Return small angles, position, angular velocity and velocity, in the axes of the heading."""
    return (
        *(ModelSignal(prefix + name, "rad") for name in ("roll", "pitch", "yaw")),
        *vector_signals(f"{prefix}p", "m"),
        *vector_signals(f"{prefix}w", "rad/s"),
        *vector_signals(f"{prefix}v", "m/s"),
    )


def rotor_signals(name: str, count: int, unit: str) -> tuple[ModelSignal, ...]:
    """Return a signal for each rotor, numbered from 1."""
    return tuple(ModelSignal(f"{name}_{index + 1}", unit) for index in range(count))


def filter_signals() -> tuple[ModelSignal, ...]:
    """Return the states of the stages before the law, see `law_signals.FilterStates`."""
    return (
        *vector_signals("filtered_v", "m/s"),
        *vector_signals("derivative_lowpass", "m/s^2"),
        *vector_signals("setpoint_lowpass_v", "m/s"),
        ModelSignal("setpoint_lowpass_yaw_rate", "rad/s"),
    )


def gyro_states() -> tuple[ModelSignal, ...]:
    """Return the states of the gyro's filters, see `GYRO_STATE_COUNT`."""
    return tuple(
        ModelSignal(f"gyro_{kind}_{axis}_{number}", "rad/s")
        for axis in "xyz"
        for kind in ("notch", "lowpass")
        for number in (1, 2)
    )


def accel_states() -> tuple[ModelSignal, ...]:
    """Return the states of the accelerometer's low-pass."""
    return tuple(
        ModelSignal(f"accel_lowpass_{axis}_{k}", "m/s^2") for axis in "xyz" for k in (1, 2)
    )


def imu_signals() -> tuple[ModelSignal, ...]:
    """Return the signals of a reading of the IMU."""
    return (*vector_signals("imu_w", "rad/s"), *vector_signals("imu_f", "m/s^2"))


def sensor_noise(samples: int) -> tuple[ModelSignal, ...]:
    """Return the noise of the IMU's samples in a period, and of other sensors."""
    if not samples:
        return ()
    return (
        *(
            ModelSignal(f"{kind}_noise_{axis}_{sample + 1}", unit)
            for sample in range(samples)
            for kind, unit in (("gyro", "rad/s"), ("accel", "m/s^2"))
            for axis in "xyz"
        ),
        *(ModelSignal(f"{name}_noise", unit) for name, unit in MEASURED_SIGNALS),
    )


def estimator_signals() -> tuple[ModelSignal, ...]:
    """Return the states common to all estimators, see `Estimator.memory` for the rest."""
    return tuple(ModelSignal(name, unit) for name, unit in NOMINAL_ERRORS)


def reference_signals() -> tuple[ModelSignal, ...]:
    """Return the references: velocity and yaw rate, and the position held."""
    return (
        *vector_signals("reference_v", "m/s"),
        ModelSignal("reference_yaw_rate", "rad/s"),
        *vector_signals("reference_p", "m"),
    )


def loop_point_signals(controller: Controller) -> tuple[ModelSignal, ...]:
    """Return the loop points: as inputs their injections, as outputs their signals."""
    return tuple(ModelSignal(name, unit) for name, unit in controller.points.items())


def wrench_signals() -> tuple[ModelSignal, ...]:
    """Return the plant's input: force along z and moment in T, see `plant.thrust_frame`."""
    return (ModelSignal("force", "N"), *vector_signals("moment", "N*m"))


def law_memory_signals(controller: Controller) -> tuple[ModelSignal, ...]:
    """Return the memory of the law."""
    return tuple(ModelSignal(state.name, state.unit) for state in controller.memory)


def output_signals(rotors: int, controller: Controller) -> tuple[ModelSignal, ...]:
    """Return the outputs of a closed loop but joints: motion, loop points, thrusts and speeds."""
    return (
        *motion_signals(),
        *loop_point_signals(controller),
        *rotor_signals("thrust", rotors, "N"),
        *rotor_signals("speed", rotors, "rad/s"),
    )
