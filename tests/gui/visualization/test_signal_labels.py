"""Signals keep the names of files; charts count rotors as the drone's parameters do."""

import pytest

from workbench.gui.visualization.signal_catalog import make_catalog, signal_label


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("rotors.thrust.0", "thrust rotor 1"),
        ("rotors.speed.3", "speed rotor 4"),
        ("wind.wind.2", "wind z"),
        ("imu.q_WS.0", "q_WS w"),
        ("magnetometer.magnetic_field.2", "magnetic_field z"),
        ("lidar.ranges.1", "ranges.1"),
        ("velocity_data.v_x", "v_x"),
    ],
)
def test_a_label_counts_from_1_and_names_components(name, label):
    assert signal_label(name) == label
    assert make_catalog({name: "1"}, ()) == {name.partition(".")[0]: [(name, "1", "", "")]}
