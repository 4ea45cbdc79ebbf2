"""A reference integrator of a multirotor, written from the equations; it shares no code.

It reads nothing but what `workbench inspect --json` prints and a sequence of rotor commands, and
imports numpy alone. Newton and Euler about the centre of mass, with rotors of inertia J about
their axes a, which turn at d ω against the body (d is +1 counter-clockwise about a, -1 clockwise)::

    m dv/dt = F + m g
    I dw/dt + w x (I w + h) + sum(J d dω/dt a) = M      h = sum(J d ω a)

I has the rotors at a standstill in it. Every rotor gives, at its hub, whose velocity through the
air has the part u across the axis,

- thrust (T (1 + g) - f ω s) a with T = k ω² + l ω, s the hub's velocity through the air along a,
  and g = e (r / 4 h)² at the height h of the hub, where a points upwards; no more than 4/15,
- drag torque -d c T a,
- RotorS' rotor drag -D ω u and rolling moment -R ω u (Furrer et al., RotorS, 2016, section 2.1),

and the body, at the centre of mass, drag of half ρ A |v| v. A rotor's speed follows its command by
a lag of first order whose two time constants blend around rest, as docs/theory.md says::

    dω/dt = u / τ_up + (e - u) / τ_down   e = command - ω   u = e (1 + (e / sqrt(e² + b²))³) / 2

A battery of the charge q (from 1 to 0) and the capacity C has the voltage U(q) without load. The
drone hovers for the duration D with it, drawing the current C / D and the power P_h; power is the
sum of T^1.5::

    dq/dt = -P / P_h / D      command = asked (U(q) - R C / D P / P_h) / U(1)

All of it is one state, integrated by the fourth-order Runge-Kutta method.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

BLEND = 3.0
"""Of a rotor's two time constants, b [rad/s]; `workbench inspect --json` does not say it."""

Rates = Callable[["ReferenceVehicle", np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""The derivative of a state, see `derivatives`."""


@dataclass(frozen=True)
class ReferenceVehicle:
    """A vehicle as `workbench inspect --json` prints it; n rotors, SI units, in the body frame."""

    mass: float
    com: np.ndarray
    inertia: np.ndarray
    hubs: np.ndarray
    axes: np.ndarray
    turns: np.ndarray
    thrust_coefficients: np.ndarray
    moment_coefficients: np.ndarray
    up: np.ndarray
    down: np.ndarray
    top: np.ndarray
    hover_speeds: np.ndarray
    drag_coefficients: np.ndarray
    rolling_coefficients: np.ndarray
    rotor_inertias: np.ndarray
    linear_coefficients: np.ndarray
    inflow_coefficients: np.ndarray
    ground_coefficients: np.ndarray
    radii: np.ndarray
    battery: dict | None
    battery_duration: float
    drag_area: float
    air_density: float
    gravity: float

    @classmethod
    def from_json(cls, text: str) -> "ReferenceVehicle":
        """Return the vehicle of a printed JSON object."""
        found = json.loads(text)

        def each(key: str) -> np.ndarray:
            return np.array([rotor[key] for rotor in found["rotors"]])

        return cls(
            mass=found["mass"],
            com=np.array(found["com"]),
            inertia=np.array(found["inertia"]),
            hubs=each("position"),
            axes=each("axis"),
            turns=each("direction"),
            thrust_coefficients=each("thrust_coefficient"),
            moment_coefficients=each("moment_coefficient"),
            up=each("time_constant_up"),
            down=each("time_constant_down"),
            top=each("max_speed"),
            hover_speeds=each("hover_speed"),
            drag_coefficients=each("rotor_drag_coefficient"),
            rolling_coefficients=each("rolling_moment_coefficient"),
            rotor_inertias=each("inertia"),
            linear_coefficients=each("linear_motor_constant"),
            inflow_coefficients=each("inflow_coefficient"),
            ground_coefficients=each("ground_effect_coefficient"),
            radii=each("propeller_radius"),
            battery=found["battery"],
            battery_duration=found["battery_duration"],
            drag_area=found["drag_area"],
            air_density=found["air_density"],
            gravity=found["gravity"],
        )

    def thrusts(self, speeds: np.ndarray) -> np.ndarray:
        """Return the thrusts at rest far from the ground (..., n) [N]."""
        return self.thrust_coefficients * speeds**2 + self.linear_coefficients * speeds

    # of the vehicle alone: worked out once, not at each of the thousands of steps

    @cached_property
    def arms(self) -> np.ndarray:
        """Hubs from the centre of mass (n, 3) [m]."""
        return self.hubs - self.com

    @cached_property
    def inverse_inertia(self) -> np.ndarray:
        return np.linalg.inv(self.inertia)

    @cached_property
    def hover_power(self) -> float:
        """The sum of T^1.5 in hover."""
        return float((self.thrusts(self.hover_speeds) ** 1.5).sum())

    @cached_property
    def charges_voltages(self) -> np.ndarray:
        """The battery's charges and its voltages without load (2, M)."""
        return np.array(self.battery["open_circuit_voltage"]).T


@dataclass(frozen=True)
class ReferenceFlight:
    """A flight at N times: place and velocity of the body frame's origin, in W."""

    time: np.ndarray
    p_WB: np.ndarray
    q_WB: np.ndarray
    v_WB: np.ndarray
    w_WB: np.ndarray
    rotor_speeds: np.ndarray


def rotation(q: np.ndarray) -> np.ndarray:
    """Return the matrix of a quaternion w, x, y, z."""
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def cross_matrix(a: np.ndarray) -> np.ndarray:
    """Return the matrix of a x."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def moment_of(arms: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Return the sum of arm x force over the rows (n, 3); `np.cross` takes five times as long."""
    (a1, a2, a3), (f1, f2, f3) = arms.T, forces.T
    return np.array([a2 @ f3 - a3 @ f2, a3 @ f1 - a1 @ f3, a1 @ f2 - a2 @ f1])


def quaternion_rate(q: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return dq/dt of an angular velocity in the body frame: half of q (0, w)."""
    return 0.5 * np.array(
        [
            -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
            q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
            q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
            q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
        ]
    )


def speed_rates(vehicle: ReferenceVehicle, speeds: np.ndarray, commands: np.ndarray) -> np.ndarray:
    """Return how fast the rotors speed up (n) [rad/s²]."""
    error = commands - speeds
    rising = 0.5 * error * (1.0 + (error / np.sqrt(error**2 + BLEND**2)) ** 3)
    return rising / vehicle.up + (error - rising) / vehicle.down


def drawn(vehicle: ReferenceVehicle, speeds: np.ndarray) -> float:
    """Return the power at rotor speeds (n) over that of hover."""
    return float((vehicle.thrusts(speeds) ** 1.5).sum() / vehicle.hover_power)


def voltage_share(vehicle: ReferenceVehicle, charge: float, speeds: np.ndarray) -> float:
    """Return the battery's voltage under load over that of the full one without load."""
    if vehicle.battery is None:
        return 1.0
    charges, voltages = vehicle.charges_voltages
    current = vehicle.battery["capacity"] / vehicle.battery_duration * drawn(vehicle, speeds)
    voltage = np.interp(charge, charges, voltages) - vehicle.battery["resistance"] * current
    return float(voltage / voltages[-1])


def air_loads(
    vehicle: ReferenceVehicle,
    air_B: np.ndarray,
    w_B: np.ndarray,
    speeds: np.ndarray,
    up_B: np.ndarray,
    height: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return force and moment about the centre of mass that the air makes, in B.

    Args:
        vehicle: what flies.
        air_B: velocity of the centre of mass through the air [m/s].
        w_B: angular velocity [rad/s].
        speeds: of the rotors (n) [rad/s].
        up_B: upwards (3).
        height: of the centre of mass above the ground [m].
    """
    arms = vehicle.arms
    thrusts = vehicle.thrusts(speeds)
    hub_air = air_B + arms @ cross_matrix(w_B).T
    along = (hub_air * vehicle.axes).sum(axis=1)
    across = hub_air - along[:, None] * vehicle.axes
    nearness = vehicle.ground_coefficients * (vehicle.radii / 4.0) ** 2
    nearness = np.minimum(nearness / (height + arms @ up_B) ** 2, 4.0 / 15.0)
    nearness = np.where(vehicle.axes @ up_B > 0.0, nearness, 0.0)
    pushes = thrusts * (1.0 + nearness) - vehicle.inflow_coefficients * speeds * along
    pulls = pushes[:, None] * vehicle.axes
    pulls -= (vehicle.drag_coefficients * speeds)[:, None] * across
    moment = moment_of(arms, pulls)
    moment -= (vehicle.turns * vehicle.moment_coefficients * thrusts) @ vehicle.axes
    moment -= (vehicle.rolling_coefficients * speeds) @ across
    size = np.sqrt(air_B @ air_B)
    drag = 0.5 * vehicle.air_density * vehicle.drag_area * size * air_B
    return pulls.sum(axis=0) - drag, moment


def derivatives(
    vehicle: ReferenceVehicle, x: np.ndarray, commands: np.ndarray, wind_W: np.ndarray
) -> np.ndarray:
    """Return d/dt of a state.

    It is q_WB, place of the centre of mass, w_WB_B, its velocity in W, rotor speeds, and charge.
    """
    q, w, v_W, speeds, charge = x[0:4], x[7:10], x[10:13], x[13:-1], x[-1]
    R_WB = rotation(q)
    force, moment = air_loads(vehicle, R_WB.T @ (v_W - wind_W), w, speeds, R_WB[2], x[6])
    commands = voltage_share(vehicle, charge, speeds) * commands
    rates = speed_rates(vehicle, speeds, commands)
    turned = vehicle.rotor_inertias * vehicle.turns
    spin, spun_up = (turned * speeds) @ vehicle.axes, (turned * rates) @ vehicle.axes
    moment = moment - spun_up - cross_matrix(w) @ (vehicle.inertia @ w + spin)
    dv = R_WB @ force / vehicle.mass - [0.0, 0.0, vehicle.gravity]
    dw = vehicle.inverse_inertia @ moment
    used = drawn(vehicle, speeds) / vehicle.battery_duration
    return np.concatenate([quaternion_rate(q, w), v_W, dw, dv, rates, [-used]])


def fly(
    vehicle: ReferenceVehicle,
    start: np.ndarray,
    speeds: np.ndarray,
    time: np.ndarray,
    commands: np.ndarray,
    duration: float,
    *,
    sample: float,
    step: float = 1 / 1024,
    wind_W: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rates: Rates = derivatives,
) -> ReferenceFlight:
    """Return the flight that held rotor commands make.

    Args:
        vehicle: what flies.
        start: q_WB, p_WB, w_WB_W, v_WB_W of the body frame's origin (13).
        speeds: of the rotors at the start (n) [rad/s].
        time: (M) when each row of commands begins to hold, from 0 [s]; whole steps.
        commands: (M, n) speeds that the rotors are to reach [rad/s].
        duration: [s].
        sample: between the flight's samples, whole steps [s].
        step: of the Runge-Kutta method [s].
        wind_W: velocity of the air [m/s].
        rates: the derivative that is integrated.
    """
    rows = np.clip(commands, 0.0, vehicle.top)
    begins = {round(t / step): row for t, row in zip(time, rows, strict=True)}
    every, count = round(sample / step), round(duration / step)
    wind = np.array(wind_W)
    q, p, w_W, v = np.split(np.array(start, float), [4, 7, 10])
    q = q / np.sqrt(q @ q)
    R_WB = rotation(q)
    arm = R_WB @ vehicle.com
    x = np.concatenate([q, p + arm, R_WB.T @ w_W, v + np.cross(w_W, arm), speeds, [1.0]])
    command = begins[0]
    samples = [x]
    for index in range(count):
        command = begins.get(index, command)
        k1 = rates(vehicle, x, command, wind)
        k2 = rates(vehicle, x + 0.5 * step * k1, command, wind)
        k3 = rates(vehicle, x + 0.5 * step * k2, command, wind)
        k4 = rates(vehicle, x + step * k3, command, wind)
        x = x + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        x[0:4] /= np.sqrt(x[0:4] @ x[0:4])
        if (index + 1) % every == 0:
            samples.append(x)
    return _flight(vehicle, np.arange(len(samples)) * sample, samples)


def _flight(
    vehicle: ReferenceVehicle, time: np.ndarray, samples: list[np.ndarray]
) -> ReferenceFlight:
    """Return samples of the centre of mass as those of the body frame's origin."""
    rows = []
    for x in samples:
        R_WB = rotation(x[0:4])
        arm, w_W = R_WB @ vehicle.com, R_WB @ x[7:10]
        rows.append((x[4:7] - arm, x[0:4], x[10:13] - np.cross(w_W, arm), w_W, x[13:-1]))
    p, q, v, w, speeds = (np.array(part) for part in zip(*rows, strict=True))
    return ReferenceFlight(time, p, q, v, w, speeds)


def angles_between(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the angles (N) between two rows of unit quaternions (N, 4) [rad]."""
    # by the distance, not the scalar product: that loses small angles to rounding
    near = np.minimum(np.linalg.norm(q - other, axis=1), np.linalg.norm(q + other, axis=1))
    return 4.0 * np.arcsin(np.minimum(0.5 * near, 1.0))
