"""Names and units of the signals of linear models."""

from workbench.control.controller import Controller
from workbench.design.linear.estimation import MEASURED, NOMINAL
from workbench.design.linear.model import Signal


def motion(prefix: str = "") -> tuple[Signal, ...]:
    """Return small angles, place, angular velocity and velocity, in the axes of the heading."""
    groups = (
        (("roll", "pitch", "yaw"), "rad"),
        (("p_x", "p_y", "p_z"), "m"),
        (("w_x", "w_y", "w_z"), "rad/s"),
        (("v_x", "v_y", "v_z"), "m/s"),
    )
    return tuple(Signal(prefix + name, unit) for names, unit in groups for name in names)


def numbered(name: str, count: int, unit: str) -> tuple[Signal, ...]:
    """Return a signal of each rotor, numbered from 1."""
    return tuple(Signal(f"{name}_{index + 1}", unit) for index in range(count))


def filtered() -> tuple[Signal, ...]:
    """Return what the stages before the law remember, see `flight_law.FILTERED`."""
    return (
        *(Signal(f"filtered_v_{axis}", "m/s") for axis in "xyz"),
        *(Signal(f"derivative_lowpass_{axis}", "m/s^2") for axis in "xyz"),
        *(Signal(f"setpoint_lowpass_v_{axis}", "m/s") for axis in "xyz"),
        Signal("setpoint_lowpass_yaw_rate", "rad/s"),
    )


def gyro_states() -> tuple[Signal, ...]:
    """Return the states of the gyro's filters, see `gyro.STATES`."""
    return tuple(
        Signal(f"gyro_{kind}_{axis}_{number}", "rad/s")
        for axis in "xyz"
        for kind in ("notch", "lowpass")
        for number in (1, 2)
    )


def accel_states() -> tuple[Signal, ...]:
    """Return the states of the accelerometer's low-pass."""
    return tuple(Signal(f"accel_lowpass_{axis}_{k}", "m/s^2") for axis in "xyz" for k in (1, 2))


def imu() -> tuple[Signal, ...]:
    """Return what the IMU gives at a reading."""
    return tuple(Signal(f"imu_w_{axis}", "rad/s") for axis in "xyz") + tuple(
        Signal(f"imu_f_{axis}", "m/s^2") for axis in "xyz"
    )


def sensor_noise(samples: int) -> tuple[Signal, ...]:
    """Return the noise of the IMU's samples in a period, and of what other sensors measure."""
    if not samples:
        return ()
    return (
        *(
            Signal(f"{kind}_noise_{axis}_{sample + 1}", unit)
            for sample in range(samples)
            for kind, unit in (("gyro", "rad/s"), ("accel", "m/s^2"))
            for axis in "xyz"
        ),
        *(Signal(f"{name}_noise", unit) for name, unit in MEASURED),
    )


def estimated() -> tuple[Signal, ...]:
    """Return what every estimator remembers, see `Estimator.memory` for the rest."""
    return tuple(Signal(name, unit) for name, unit in NOMINAL)


def yaw_moment() -> tuple[Signal, ...]:
    """Return the yaw moment that the continuous law asks for, see `systems.controller`."""
    return (Signal("yaw_moment", "N*m"),)


def accelerations() -> tuple[Signal, ...]:
    """Return the accelerations in the middle of the step before."""
    return tuple(Signal(f"wdot_{axis}", "rad/s^2") for axis in "xyz") + tuple(
        Signal(f"vdot_{axis}", "m/s^2") for axis in "xyz"
    )


def references() -> tuple[Signal, ...]:
    """Return what is asked for: velocity and yaw rate, and the place that is held."""
    return (
        *(Signal(f"reference_v_{axis}", "m/s") for axis in "xyz"),
        Signal("reference_yaw_rate", "rad/s"),
        *(Signal(f"reference_p_{axis}", "m") for axis in "xyz"),
    )


def points(controller: Controller) -> tuple[Signal, ...]:
    """Return the loop points: as inputs their injections, as outputs their signals."""
    return tuple(Signal(name, unit) for name, unit in controller.points.items())


def wrench() -> tuple[Signal, ...]:
    """Return the plant's input: force along z and moment in T, see `plant.thrust_frame`."""
    return (Signal("force", "N"), *(Signal(f"moment_{axis}", "N*m") for axis in "xyz"))


def memory_of(controller: Controller) -> tuple[Signal, ...]:
    """Return what the law remembers."""
    return tuple(Signal(state.name, state.unit) for state in controller.memory)


def outputs(rotors: int, controller: Controller) -> tuple[Signal, ...]:
    """Return what comes out of a closed loop: motion, loop points, thrusts and speeds."""
    return (
        *motion(),
        *points(controller),
        *numbered("thrust", rotors, "N"),
        *numbered("speed", rotors, "rad/s"),
    )
