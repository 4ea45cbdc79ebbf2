"""The recording of a flight: arrays over time, and quantities derived from them."""

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.common.plain_files import atomic_file, make_folder
from workbench.common.series import TimedArrays
from workbench.control.flight_mode import REASON_INDEX
from workbench.plant.rotors import wrench_matrix
from workbench.plant.vehicle import Vehicle

PART_FIELDS = {
    "joint": "joints",
    "joint_setpoint": "joint_setpoints",
    "tension": "tensions",
    "contact": "contact_forces",
}
"""Fields of a recording with what is of parts, by the first part of its names in a table."""
_OPTIONAL_SIGNALS = (
    *("estimate", "deviations", "covariance", "innovations", "known_charge"),
    *PART_FIELDS.values(),
)
"""Signals of a flight with an estimator, or with joints; (N, 0) without."""


def part_signals(vehicle: Vehicle) -> list[tuple[str, str, tuple[tuple[str, str], ...]]]:
    """Return what a recording has of a vehicle's joints, servos, cables and touching bodies: the
    group of each, see `PART_FIELDS`, its field, and name and unit of each column of that.
    """
    setpoints = tuple((each.joint, each.setpoint_unit) for each in vehicle.servos)
    forces = tuple((f"{link}.{axis}", "N") for link in vehicle.contact_links for axis in "xyz")
    tensions = tuple((cable, "N") for cable in vehicle.cables)
    rows = (vehicle.joint_signals, setpoints, tensions, forces)
    return [(*names, each) for names, each in zip(PART_FIELDS.items(), rows, strict=True)]


def _empty_array() -> np.ndarray:
    return np.empty((0, 0))


@dataclass(frozen=True)
class Recording(TimedArrays):
    """A flight at evenly spaced times; N samples, n rotors, SI units.

    Attributes:
        vehicle: the flown vehicle.
        time: (N) [s].
        p_WB: (N, 3) position [m].
        q_WB: (N, 4) orientation, unit quaternion w, x, y, z.
        v_WB: (N, 3) velocity in W [m/s].
        w_WB: (N, 3) angular velocity in W [rad/s].
        vdot_WB: (N, 3) acceleration in W, mean over the preceding physics step [m/s²].
        wdot_WB: (N, 3) angular acceleration in W, over the same step [rad/s²].
        commanded_speeds: (N, n) commanded rotor speeds of the control period that ends now [rad/s].
        rotor_speeds: (N, n) speeds of the rotors [rad/s].
        thrusts: (N, n) thrusts of the rotors [N].
        reference: (N, 8) the pilot's command until now, see `control.guidance.Reference`.
        mode: (N) flight mode, see `control.mode.FlightMode`.
        charge: (N) charge of the battery, 0 .. 1.
        wind_W: (N, 3) velocity of the air at the drone [m/s].
        clearance: (N) free distance to the nearest obstacle [m], infinite without one.
        estimate: (N, 13) motion as known to the controller: q_WB, p_WB [m], w_WB [rad/s] and v_WB
            [m/s] in W; (N, 0) if it knew the true one. The same applies to the next three.
        deviations: (N, 15) standard deviations of its errors: attitude in B [rad], position and
            velocity of the IMU in W, biases of gyro and accelerometer; NaN if the estimator does
            not know them. The same applies to the next two.
        covariance: (N, 45) covariance of the first nine errors, upper triangle row by row.
        innovations: (N, 20) innovation and its variance for each measured number, see
            `ekf_state.MEASUREMENT_CHANNELS`; NaN without a measurement at that time.
        known_charge: (N, 1) the charge as known to the controller, 0 .. 1; (N, 0) if it knew the
            true one, or no battery is stated.
        reason: (N) why the mode differs from the requested one, see `control.mode.Reason`.
        joints: (N, 2 j) positions and velocities of joints, see `Vehicle.joint_signals`; (N, 0)
            without any.
        joint_setpoints: (N, k) of the servos, in the order of the vehicle, behind their delays,
            low-passes and limits; (N, 0) without any.
        tensions: (N, c) of the cables [N], 0 of a slack one; (N, 0) without any.
        contact_forces: (N, 3 b) of ground and obstacles on the bodies of `Vehicle.contact_links` in
            W [N]; (N, 0) without joints.
    """

    vehicle: Vehicle
    time: np.ndarray
    p_WB: np.ndarray
    q_WB: np.ndarray
    v_WB: np.ndarray
    w_WB: np.ndarray
    vdot_WB: np.ndarray
    wdot_WB: np.ndarray
    commanded_speeds: np.ndarray
    rotor_speeds: np.ndarray
    thrusts: np.ndarray
    reference: np.ndarray
    mode: np.ndarray
    charge: np.ndarray
    wind_W: np.ndarray
    clearance: np.ndarray
    estimate: np.ndarray = field(default_factory=_empty_array)
    deviations: np.ndarray = field(default_factory=_empty_array)
    covariance: np.ndarray = field(default_factory=_empty_array)
    innovations: np.ndarray = field(default_factory=_empty_array)
    reason: np.ndarray = field(default_factory=_empty_array)
    known_charge: np.ndarray = field(default_factory=_empty_array)
    joints: np.ndarray = field(default_factory=_empty_array)
    joint_setpoints: np.ndarray = field(default_factory=_empty_array)
    tensions: np.ndarray = field(default_factory=_empty_array)
    contact_forces: np.ndarray = field(default_factory=_empty_array)

    def __repr__(self) -> str:
        return f"<Recording of {self.vehicle.name}: {len(self.time)} samples>"

    @classmethod
    def from_signals(
        cls, vehicle: Vehicle, time: np.ndarray, signals: Mapping[str, np.ndarray]
    ) -> "Recording":
        """Return a recording made from logged signals.

        Args:
            vehicle: the flown vehicle.
            time: (N) [s].
            signals: (N, size) each, as in the recorder: state (13) and acceleration (6) of the
                body, speeds, commands and thrusts of the rotors (n), reference (8), mode (mode,
                ...), charge (1), wind (3); obstacle (clearance, ...) in a world that has obstacles;
                estimate (13), deviations (15), covariance (45) and innovations (20) with an
                estimator, and known_charge (1) if it knows of a battery.
        """
        state, acceleration = signals["state"], signals["acceleration"]
        return cls(
            vehicle=vehicle,
            time=time,
            q_WB=state[:, 0:4] / np.linalg.norm(state[:, 0:4], axis=1, keepdims=True),
            p_WB=state[:, 4:7],
            w_WB=state[:, 7:10],
            v_WB=state[:, 10:13],
            wdot_WB=acceleration[:, 0:3],
            vdot_WB=acceleration[:, 3:6],
            commanded_speeds=signals["commands"],
            rotor_speeds=signals["speeds"],
            thrusts=signals["thrusts"],
            reference=signals["reference"],
            mode=signals["mode"][:, 0],
            charge=signals["charge"][:, 0],
            wind_W=signals["wind"],
            clearance=(
                signals["obstacle"][:, 0] if "obstacle" in signals else np.full(len(time), np.inf)
            ),
            reason=_reasons(signals["mode"]),
            **{name: signals.get(name, np.empty((len(time), 0))) for name in _OPTIONAL_SIGNALS},
        )

    @property
    def estimated(self) -> bool:
        """Whether the controller used an estimate instead of the true motion."""
        return self.estimate.size > 0

    @property
    def p_BI(self) -> np.ndarray:
        """Position of the estimator's IMU in B (3) [m]: the first one."""
        places = (each.p_BS for each in self.vehicle.body_imus)
        return np.array(next(places, (0.0, 0.0, 0.0)))

    @property
    def z_axis_W(self) -> np.ndarray:
        """Body z in W, (N, 3)."""
        w, x, y, z = self.q_WB.T
        return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)

    @property
    def slack_time(self) -> float:
        """How long any cable was slack [s]; with open hooks all are."""
        slack = (self.tensions == 0.0).any(axis=1) if self.tensions.size else np.zeros(1, bool)
        return float(slack[:-1] @ np.diff(self.time)) if slack.any() else 0.0

    @property
    def total_thrust(self) -> np.ndarray:
        """Sum of the rotors' thrusts along body z, (N) [N]."""
        return self._wrench_B()[:, 2]

    @property
    def force_W(self) -> np.ndarray:
        """Total force of all rotors in W, (N, 3) [N]; for rotors that push along body z."""
        return self.total_thrust[:, None] * self.z_axis_W

    @property
    def moment_B(self) -> np.ndarray:
        """Moment of all rotors about the centre of mass in B, (N, 3) [N·m].

        Drag torques follow from the recorded thrusts, with inflow and ground effect.
        """
        return self._wrench_B()[:, 3:]

    @property
    def rotor_use(self) -> np.ndarray:
        """Largest share of its speed limit that any rotor has, (N)."""
        limits = np.array([rotor.max_rot_velocity for rotor in self.vehicle.rotors])
        return np.max(self.rotor_speeds / limits, axis=1)

    @property
    def tilt(self) -> np.ndarray:
        """Angle between body z and the vertical, (N) [rad]."""
        return np.arccos(np.clip(self.z_axis_W[:, 2], -1.0, 1.0))

    def _wrench_B(self) -> np.ndarray:
        """Force and moment about the centre of mass in B, (N, 6)."""
        matrix = wrench_matrix(self.vehicle.rotors, self.vehicle.p_BoBcm_B)
        return self.thrusts @ matrix.T

    def write_csv(self, path: Path) -> None:
        """Write one row per sample, with units in the header.

        Raises:
            WorkbenchError: if the file cannot be written; no partial file remains.
        """
        columns = self._columns()
        table = np.column_stack(list(columns.values()))
        make_folder(path.parent)
        with atomic_file(path) as stream:
            file = io.TextIOWrapper(stream, encoding="utf-8", newline="")
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows(table.tolist())
            file.detach()  # all is in the stream, which stays open

    def _columns(self) -> dict[str, np.ndarray]:
        """Return every signal as named columns."""
        columns = {"t [s]": self.time}
        groups = (
            ("p_W", "xyz", "m", self.p_WB),
            ("q_WB", "wxyz", "1", self.q_WB),
            ("v_W", "xyz", "m/s", self.v_WB),
            ("w_W", "xyz", "rad/s", self.w_WB),
            ("vdot_W", "xyz", "m/s^2", self.vdot_WB),
            ("wdot_W", "xyz", "rad/s^2", self.wdot_WB),
            ("force_W", "xyz", "N", self.force_W),
            ("moment_B", "xyz", "N m", self.moment_B),
            ("wind_W", "xyz", "m/s", self.wind_W),
        )
        for name, axes, unit, values in groups:
            for index, axis in enumerate(axes):
                columns[f"{name}.{axis} [{unit}]"] = values[:, index]
        for index in range(self.thrusts.shape[1]):
            columns[f"speed_command.{index + 1} [rad/s]"] = self.commanded_speeds[:, index]
            columns[f"speed.{index + 1} [rad/s]"] = self.rotor_speeds[:, index]
            columns[f"thrust.{index + 1} [N]"] = self.thrusts[:, index]
        columns["command.v_x [m/s]"] = self.reference[:, 0]
        columns["command.v_y [m/s]"] = self.reference[:, 1]
        columns["command.v_z [m/s]"] = self.reference[:, 2]
        columns["command.yaw_rate [rad/s]"] = self.reference[:, 3]
        columns["mode [1]"] = self.mode
        columns["charge [1]"] = self.charge
        if np.isfinite(self.clearance).any():
            columns["clearance [m]"] = self.clearance
        follows = self.reference[:, 7] == 1.0
        if follows.any():
            for index, axis in enumerate("xyz", start=4):
                columns[f"setpoint.{axis} [m]"] = np.where(
                    follows, self.reference[:, index], np.nan
                )
        for group, field_name, rows in part_signals(self.vehicle):
            values = getattr(self, field_name)
            if values.size:
                named = zip(rows, values.T, strict=True)
                columns |= {f"{group}.{name} [{unit}]": column for (name, unit), column in named}
        return columns | self._estimated_columns()

    def _estimated_columns(self) -> dict[str, np.ndarray]:
        """Return the estimate and its deviations as named columns, none without an estimator."""
        if not self.estimated:
            return {}
        columns = estimate_columns(self.estimate, self.deviations)
        if self.known_charge.size:
            columns["estimate.charge [1]"] = self.known_charge[:, 0]
        return columns


def estimate_columns(estimate: np.ndarray, deviations: np.ndarray) -> dict[str, np.ndarray]:
    """Return an estimate (N, 13) and its deviations (N, 15) as named columns, see `Recording`."""
    groups = (
        ("estimate.q_WB", "wxyz", "1", estimate[:, 0:4]),
        ("estimate.p_W", "xyz", "m", estimate[:, 4:7]),
        ("estimate.v_W", "xyz", "m/s", estimate[:, 10:13]),
        ("estimate.w_W", "xyz", "rad/s", estimate[:, 7:10]),
        ("deviation.attitude_B", "xyz", "rad", deviations[:, 0:3]),
        ("deviation.p_W", "xyz", "m", deviations[:, 3:6]),
        ("deviation.v_W", "xyz", "m/s", deviations[:, 6:9]),
        ("deviation.gyro_bias", "xyz", "rad/s", deviations[:, 9:12]),
        ("deviation.accel_bias", "xyz", "m/s^2", deviations[:, 12:15]),
    )
    return {
        f"{name}.{axis} [{unit}]": values[:, index]
        for name, axes, unit, values in groups
        for index, axis in enumerate(axes)
    }


def _reasons(mode: np.ndarray) -> np.ndarray:
    """Return the reasons in recorded states of the flight mode, zeros if they have none."""
    found: np.ndarray = (
        mode[:, REASON_INDEX] if mode.shape[1] > REASON_INDEX else np.zeros(len(mode))
    )
    return found
