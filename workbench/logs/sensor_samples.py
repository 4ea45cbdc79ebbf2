"""The sensor samples of a logged flight, for an estimator."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.diagram.mounting import (
    deviations_at_start,
    gps_repeats,
    magnetometer_turn,
    mounting_of,
)
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.ekf_state import ERRORS
from workbench.estimation.estimators import Estimator
from workbench.estimation.run import SensorSamples, StampedSamples
from workbench.estimation.samples import Mounting
from workbench.logs.record import LogRecord
from workbench.plant.geodesy import point_in_world
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.sensors import Imu
from workbench.scenario.configured import configured_vehicle, read_configured_world
from workbench.scenario.sensor_choice import choose_sensors


@dataclass(frozen=True)
class LoggedSensors:
    """A logged flight with its sensor samples, for an estimator.

    Attributes:
        samples: of the sensors.
        mounting: of the sensors.
        known: initial uncertainty of an estimate.
        state_time: of the true motion (N) [s].
        states: the true motion: q_WB, p_WB, w_WB_W, v_WB_W (N, 13).
    """

    samples: SensorSamples
    mounting: Mounting
    known: InitialDeviations
    state_time: np.ndarray
    states: np.ndarray

    def begin(self, estimator: Estimator) -> np.ndarray:
        """Return the memory of an estimator that begins at the true motion."""
        start = self.samples.imu.stamp[0]
        state = self.states[max(0, np.searchsorted(self.state_time, start, "right") - 1)]
        return estimator.begin(state, self.mounting, np.zeros(ERRORS), self.known)


def logged_sensors(record: LogRecord) -> LoggedSensors:
    """Return the sensor samples of a flight, in the axes of the vehicle in its scenario.

    Raises:
        WorkbenchError: if the log has no samples of an IMU or no true motion at the start, or the
            vehicle of the scenario is missing or has changed.
    """
    if "imu" not in record.topics:
        raise WorkbenchError(
            f"{record.path}: has no samples of an IMU, which every estimator needs: fly it with "
            "`--estimator ekf --log FILE`, or with `--sensors imu,gps,magnetometer --log FILE`"
        )
    if not len(record.states):
        raise WorkbenchError(
            f"{record.path}: has no exact states: an estimate begins with the first one, and is "
            "compared with them"
        )
    scenario = record.scenario()
    vehicle = configured_vehicle(scenario.vehicle)
    if vehicle.name != record.vehicle:
        raise WorkbenchError(
            f"{record.path}: was flown by {record.vehicle}, and {scenario.vehicle.model} is "
            f"{vehicle.name} now: where its sensors were mounted is no longer known"
        )
    choices = choose_sensors(vehicle, scenario)
    home = read_configured_world(scenario).home or DEFAULT_HOME
    imu = next((each.sensor for each in choices if isinstance(each.sensor, Imu)), None)
    if imu is None:
        raise WorkbenchError(
            f"{record.path}: has samples of an IMU, but {vehicle.source} has none now: where it "
            "was mounted is no longer known"
        )
    if vehicle.is_moved(imu.link):
        raise WorkbenchError(
            f"{record.path}: its IMU '{imu.name}' is on a link that joints move, and estimates "
            f"need one that they do not: declare that first in {vehicle.source}"
        )
    samples = _imu_samples(record, np.array(imu.R_BS))
    state_time = np.array(record.state_ns, dtype=np.int64) * 1e-9
    compared = (samples.stamp >= state_time[0]) & (samples.stamp <= state_time[-1])
    if not compared.any():
        raise WorkbenchError(
            f"{record.path}: has no samples of an IMU between its first and its last exact state"
        )
    return LoggedSensors(
        samples=SensorSamples(
            imu=StampedSamples(*(each[compared] for each in samples)),
            gps=_gps_samples(record, home, samples, repeats=gps_repeats(choices)),
            magnetometer=_magnetometer_samples(record, magnetometer_turn(choices)),
        ),
        mounting=mounting_of(imu, choices, home),
        known=deviations_at_start(imu),
        state_time=state_time,
        states=record.states,
    )


def _imu_samples(record: LogRecord, R_BS: np.ndarray) -> StampedSamples:
    rates = _topic_columns(record, "imu", [f"angular_velocity.{axis}" for axis in "xyz"])
    forces = _topic_columns(record, "imu", [f"linear_acceleration.{axis}" for axis in "xyz"])
    topic = record.topics["imu"]
    return _in_order(topic.stamps, topic.time, np.hstack([rates @ R_BS.T, forces @ R_BS.T]))


def _gps_samples(
    record: LogRecord, home: Home, imu: StampedSamples, *, repeats: bool
) -> StampedSamples | None:
    """Return the samples of the GPS, without those that are ignored in flight, too.

    A frozen GPS repeats its sample to the bit in the air, see `systems.navigation`.
    """
    if "gps" not in record.topics or "gps_velocity" not in record.topics:
        return None
    places, velocities = record.topics["gps"], record.topics["gps_velocity"]
    # a damaged chunk may have cost one of the two
    _, first, second = np.intersect1d(places.stamps, velocities.stamps, return_indices=True)
    fixes = _topic_columns(record, "gps", ["latitude", "longitude", "altitude"])[first]
    latitude, longitude = np.radians(fixes[:, :2]).T
    p_W = point_in_world(latitude, longitude, fixes[:, 2], home)
    v_W = _topic_columns(record, "gps_velocity", [f"twist.linear.{axis}" for axis in "xyz"])[second]
    values = np.column_stack([*p_W, v_W])
    told = _in_order(places.stamps[first], places.time[first], values)
    if repeats or "drone_state" not in record.topics or not len(told.stamp):
        return told
    mode = record.topics["drone_state"].columns["mode"]
    then = mode.values[np.maximum(np.searchsorted(mode.time, told.stamp, "right") - 1, 0)]
    after = np.clip(np.searchsorted(imu.stamp, told.stamp, "right"), 1, len(imu.stamp) - 1)
    frozen = np.append(False, (told.values[1:] == told.values[:-1]).all(axis=1))
    frozen &= ~np.isin(then, (FlightMode.OFF, FlightMode.ARMED))
    frozen &= (imu.values[after, :3] != imu.values[after - 1, :3]).any(axis=1)
    return StampedSamples(*(each[~frozen] for each in told))


def _magnetometer_samples(record: LogRecord, R_BM: np.ndarray) -> StampedSamples | None:
    if "magnetometer" not in record.topics:
        return None
    topic = record.topics["magnetometer"]
    fields = _topic_columns(record, "magnetometer", [f"magnetic_field.{axis}" for axis in "xyz"])
    return _in_order(topic.stamps, topic.time, fields @ R_BM.T)


def _topic_columns(record: LogRecord, topic: str, fields: Sequence[str]) -> np.ndarray:
    columns = record.topics[topic].columns
    missing = [field for field in fields if field not in columns]
    if missing:
        raise WorkbenchError(f"{record.path}: its topic {topic} has no {missing[0]}: it is damaged")
    return np.column_stack([columns[field].values for field in fields])


def _in_order(stamp: np.ndarray, arrived: np.ndarray, values: np.ndarray) -> StampedSamples:
    """Return samples with increasing stamps; repeated and non-finite samples are left out."""
    good = np.isfinite(values).all(axis=1)
    good &= np.diff(np.maximum.accumulate(stamp), prepend=-np.inf) > 0.0
    return StampedSamples(stamp[good], arrived[good], values[good])
