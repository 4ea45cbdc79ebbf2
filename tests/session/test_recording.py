"""Oracles: rotations of pydrake.math, sums by hand, and the CSV file read back."""

import csv
import dataclasses
import math

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model
from workbench.plant.loading import load_vehicle
from workbench.plant.rotors import wrench_matrix
from workbench.session.recording import Recording

N = 20


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(find_model("dh_drone"))


def signals() -> dict[str, np.ndarray]:
    """Random signals as the recorder has them."""
    rng = np.random.default_rng(24)
    sizes = {"state": 13, "acceleration": 6, "thrusts": 4, "reference": 8}
    sizes |= {"speeds": 4, "commands": 4, "wind": 3, "obstacle": 5}
    found = {name: rng.normal(size=(N, size)) for name, size in sizes.items()}
    found["thrusts"] = np.abs(found["thrusts"])
    found["speeds"] = np.abs(found["speeds"])
    return found | {"mode": rng.integers(0, 8, (N, 9)) * 1.0, "charge": rng.random((N, 1))}


@pytest.fixture(scope="module")
def recording(vehicle):
    return Recording.from_signals(vehicle, 0.5 * np.arange(N), signals())


def test_signals_find_their_places(recording):
    raw = signals()
    state = raw["state"]
    length = np.linalg.norm(state[:, :4], axis=1)
    assert recording.q_WB * length[:, None] == pytest.approx(state[:, :4])
    assert np.linalg.norm(recording.q_WB, axis=1) == pytest.approx(np.ones(N))
    assert recording.p_WB.tolist() == state[:, 4:7].tolist()
    assert recording.w_WB.tolist() == state[:, 7:10].tolist()
    assert recording.v_WB.tolist() == state[:, 10:13].tolist()
    assert recording.wdot_WB.tolist() == raw["acceleration"][:, :3].tolist()
    assert recording.vdot_WB.tolist() == raw["acceleration"][:, 3:].tolist()
    assert recording.rotor_speeds.tolist() == raw["speeds"].tolist()
    assert recording.commanded_speeds.tolist() == raw["commands"].tolist()
    assert recording.thrusts.tolist() == raw["thrusts"].tolist()
    assert recording.reference.tolist() == raw["reference"].tolist()
    assert recording.mode.tolist() == raw["mode"][:, 0].tolist()
    assert recording.charge.tolist() == raw["charge"][:, 0].tolist()
    assert recording.wind_W.tolist() == raw["wind"].tolist()
    assert recording.clearance.tolist() == raw["obstacle"][:, 0].tolist()


def test_without_obstacles_the_way_is_free(vehicle):
    raw = signals()
    del raw["obstacle"]
    free = Recording.from_signals(vehicle, 0.5 * np.arange(N), raw)
    assert free.clearance.tolist() == [math.inf] * N


def test_forces_and_moments_are_those_of_the_thrusts(recording, vehicle):
    matrix = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)
    for i in range(N):
        R_WB = RotationMatrix(Quaternion(recording.q_WB[i])).matrix()
        wrench = matrix @ recording.thrusts[i]
        assert recording.total_thrust[i] == pytest.approx(recording.thrusts[i].sum())
        assert recording.force_W[i] == pytest.approx(R_WB @ wrench[:3], abs=1e-12)
        assert recording.moment_B[i] == pytest.approx(wrench[3:], abs=1e-12)
        assert recording.z_axis_W[i] == pytest.approx(R_WB[:, 2], abs=1e-12)
        tilt = math.acos(R_WB[2, 2])
        assert recording.tilt[i] == pytest.approx(tilt, abs=1e-7)


def test_rotor_use_is_the_largest_share_of_a_limit(recording, vehicle):
    limit = vehicle.rotors[0].max_rot_velocity
    assert recording.rotor_use == pytest.approx(recording.rotor_speeds.max(axis=1) / limit)


def test_a_part_has_both_its_ends(recording):
    part = recording.between(1.0, 2.5)
    assert part.time.tolist() == [1.0, 1.5, 2.0, 2.5]
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            whole = getattr(recording, field.name)
            assert getattr(part, field.name).tolist() == whole[2:6].tolist(), field.name
    assert part.vehicle is recording.vehicle
    assert len(recording.between(100.0, 200.0).time) == 0


def test_a_csv_file_has_every_number_under_its_name_and_unit(recording, tmp_path):
    path = tmp_path / "new" / "flight.csv"
    recording.write_csv(path)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == N

    def column(name):
        return np.array([float(row[name]) for row in rows])

    assert column("t [s]").tolist() == recording.time.tolist()
    assert column("p_W.y [m]").tolist() == recording.p_WB[:, 1].tolist()
    assert column("q_WB.w [1]").tolist() == recording.q_WB[:, 0].tolist()
    assert column("v_W.z [m/s]").tolist() == recording.v_WB[:, 2].tolist()
    assert column("w_W.x [rad/s]").tolist() == recording.w_WB[:, 0].tolist()
    assert column("vdot_W.x [m/s^2]").tolist() == recording.vdot_WB[:, 0].tolist()
    assert column("wdot_W.z [rad/s^2]").tolist() == recording.wdot_WB[:, 2].tolist()
    assert column("force_W.z [N]").tolist() == recording.force_W[:, 2].tolist()
    assert column("moment_B.y [N m]").tolist() == recording.moment_B[:, 1].tolist()
    assert column("speed_command.2 [rad/s]").tolist() == recording.commanded_speeds[:, 1].tolist()
    assert column("speed.3 [rad/s]").tolist() == recording.rotor_speeds[:, 2].tolist()
    assert column("thrust.4 [N]").tolist() == recording.thrusts[:, 3].tolist()
    assert column("command.v_x [m/s]").tolist() == recording.reference[:, 0].tolist()
    assert column("command.yaw_rate [rad/s]").tolist() == recording.reference[:, 3].tolist()
    assert column("mode [1]").tolist() == recording.mode.tolist()
    assert column("charge [1]").tolist() == recording.charge.tolist()
    assert not any(name.startswith("setpoint") for name in rows[0])
    assert [p.name for p in path.parent.iterdir()] == ["flight.csv"]
    reference = recording.reference.copy()
    reference[:, 7] = np.arange(N) % 2  # it goes to a place in every other row
    dataclasses.replace(recording, reference=reference).write_csv(path)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    wanted = np.where(reference[:, 7] == 1.0, reference[:, 5], np.nan)
    np.testing.assert_array_equal(column("setpoint.y [m]"), wanted)


def test_what_cannot_be_written_is_named(recording, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(WorkbenchError, match=f"{tmp_path}/file: cannot be made"):
        recording.write_csv(tmp_path / "file" / "a.csv")
    (tmp_path / "folder").mkdir()
    with pytest.raises(WorkbenchError, match="cannot be written"):
        recording.write_csv(tmp_path / "folder")


@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failed_write_leaves_the_old_file_and_no_other(recording, tmp_path, monkeypatch, failure):
    path = tmp_path / "flight.csv"
    path.write_text("old")

    class FullDisk:
        def writerow(self, row):
            pass

        def writerows(self, rows):
            raise failure

    monkeypatch.setattr("workbench.session.recording.csv.writer", lambda file: FullDisk())
    with pytest.raises((WorkbenchError, KeyboardInterrupt)):
        recording.write_csv(path)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["flight.csv"]


def test_an_estimate_is_recorded_where_one_flew(vehicle, recording, tmp_path):
    assert not recording.estimated
    assert recording.deviations.shape == (N, 0)
    rng = np.random.default_rng(7)
    sizes = {"estimate": 13, "deviations": 15, "covariance": 45, "innovations": 20}
    own = {name: rng.normal(size=(N, size)) for name, size in sizes.items()}
    flown = Recording.from_signals(vehicle, 0.5 * np.arange(N), signals() | own)
    part = flown.between(1.0, 3.0)
    for name, values in own.items():
        assert getattr(flown, name).tolist() == values.tolist()
        assert getattr(part, name).tolist() == values[2:7].tolist()
    path = tmp_path / "flight.csv"
    flown.write_csv(path)
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for name, values in (
        ("estimate.q_WB.w [1]", own["estimate"][:, 0]),
        ("estimate.p_W.z [m]", own["estimate"][:, 6]),
        ("estimate.w_W.x [rad/s]", own["estimate"][:, 7]),
        ("estimate.v_W.y [m/s]", own["estimate"][:, 11]),
        ("deviation.attitude_B.z [rad]", own["deviations"][:, 2]),
        ("deviation.p_W.x [m]", own["deviations"][:, 3]),
        ("deviation.v_W.x [m/s]", own["deviations"][:, 6]),
        ("deviation.gyro_bias.y [rad/s]", own["deviations"][:, 10]),
        ("deviation.accel_bias.z [m/s^2]", own["deviations"][:, 14]),
    ):
        assert [float(row[name]) for row in rows] == values.tolist(), name
    recording.write_csv(path)
    assert "estimate" not in path.read_text(encoding="utf-8").splitlines()[0]
