"""The gyro of a tumbling vehicle, beside scipy's filters over the angular velocities flown."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from scipy import signal
from scipy.spatial.transform import Rotation

from workbench.control.controller_file import load_controller
from workbench.diagram.airframe import add_airframe
from workbench.estimation.gyro import GyroSettings, sample_steps
from workbench.plant.loading import make_vehicle
from workbench.scenario.scenario import Rates

STEP = 1 / 1024
TUMBLING = [0.8, 0.3, -0.4, 0.3317, 0.0, 0.0, 80.0, 4.0, -7.0, 3.0, 1.0, 0.0, 0.0]
SETTINGS = (
    ("low-pass", GyroSettings()._replace(gyro_lowpass=60.0), 1),
    ("first order", GyroSettings()._replace(gyro_lowpass=30.0, gyro_lowpass_order=1.0), 1),
    ("notch", GyroSettings()._replace(gyro_notch=100.0, gyro_notch_width=40.0), 1),
    (
        "both, sampled",
        GyroSettings()._replace(gyro_rate=500.0, gyro_lowpass=50.0, gyro_notch=90.0),
        2,
    ),
    ("slow", GyroSettings()._replace(gyro_rate=100.0, gyro_lowpass=20.0), 8),
)


def tumble(description, gyro, steps=400):
    """Return the angular velocities in B before each step, and those that the gyro gives."""
    builder = DiagramBuilder()
    commands = builder.AddSystem(ConstantVectorSource([500.0, 700.0, 300.0, 600.0]))
    values = load_controller().table.defaults() | gyro._asdict()
    airframe = add_airframe(
        builder, description.undrawn(), values, vehicle=make_vehicle(description), rates=Rates()
    )
    builder.Connect(commands.get_output_port(), airframe.commands)
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    start = np.array(TUMBLING)
    start[:4] /= np.linalg.norm(start[:4])
    airframe.place(root, start, np.full(4, 600.0))
    in_imu = airframe.imu.GetMyContextFromRoot(root)
    true, given = [], []
    for step in range(steps):
        truth, sensed = airframe.body_state(root), airframe.sensed.Eval(in_imu)
        for state, rows in ((truth, true), (sensed, given)):
            turn = Rotation.from_quat(state[[1, 2, 3, 0]])
            rows.append(turn.inv().apply(state[7:10]))
        rest = [0, 1, 2, 3, 4, 5, 6, 10, 11, 12]
        assert sensed[rest].tolist() == truth[rest].tolist()
        simulator.AdvanceTo((step + 1) * STEP)
    return np.array(true), np.array(given)


def by_scipy(gyro, every, true):
    """Return the samples (M, 3) that were steady before the first."""
    rate = 1.0 / (every * STEP)
    found = true[::every]
    if gyro.gyro_notch:
        width = gyro.gyro_notch / gyro.gyro_notch_width
        found = steadily(*signal.iirnotch(gyro.gyro_notch, width, fs=rate), found)
    if gyro.gyro_lowpass:
        order = int(gyro.gyro_lowpass_order)
        found = steadily(*signal.butter(order, gyro.gyro_lowpass, fs=rate), found)
    return np.repeat(found, every, axis=0)[: len(true)]


def steadily(b, a, samples):
    start = np.outer(signal.lfilter_zi(b, a), samples[0])
    return signal.lfilter(b, a, samples, axis=0, zi=start)[0]


def test_it_gives_what_scipys_filters_make_of_its_samples(case, description):
    for name, gyro, every in SETTINGS:
        with case(name):
            true, given = tumble(description, gyro)
            wanted = by_scipy(gyro, every, true)
            # read as the law does; the samples between updates are those of cubics
            assert np.abs(given - wanted)[::8].max() < 3e-4
            assert np.abs(given - true)[::8].max() > 0.01


def test_without_filters_the_state_is_sensed_as_it_is(description):
    for gyro in (GyroSettings(), GyroSettings()._replace(gyro_rate=100.0, gyro_lowpass=70.0)):
        true, given = tumble(description, gyro, 60)
        assert given.tolist() == true.tolist()


@pytest.mark.parametrize(
    ("rate", "steps", "every"),
    [(0.0, 8, 1), (1024.0, 8, 1), (513.0, 8, 1), (512.0, 8, 2), (10.0, 8, 8), (200.0, 6, 3)],
)
def test_a_sample_falls_on_every_update(rate, steps, every):
    assert sample_steps(rate, STEP, steps) == every
