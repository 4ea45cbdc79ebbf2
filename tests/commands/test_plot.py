"""`workbench plot`."""

import numpy as np
import pytest
import scipy.signal

from workbench.logs.flight_log import FlightLog
from workbench.logs.plots import plot_fields, plot_overview, plot_spectra
from workbench.logs.record import read_log
from workbench.logs.spectrum import WelchSettings
from workbench.scenario.scenario import Scenario

PNG = b"\x89PNG"


def test_without_fields_there_is_an_overview(run, log, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = run("plot", log)
    assert said.code == 0, said.err
    assert (tmp_path / "out" / "flight.png").read_bytes()[:4] == PNG
    assert said.err == "workbench: wrote out/flight.png\n"


def test_the_overview_has_the_flown_curves(log):
    flight = read_log(log).flight
    position, velocity, attitude, yaw, thrust = plot_overview(flight).axes
    assert [len(axes.get_lines()) for axes in (position, attitude, thrust)] == [3, 3, 4]
    assert [len(axes.get_lines()) for axes in (velocity, yaw)] == [6, 2]
    assert position.get_ylabel() == "[m]"
    drawn = velocity.get_lines()[0].get_ydata()
    assert drawn.tolist() == flight["velocity_data.v_x"].values.tolist()


def test_fields_of_one_unit_share_a_panel(log):
    names = ["velocity_data.v_x", "command_velocity.v_x", "rotors.thrust", "position_data.x"]
    speeds, thrusts, places = plot_fields(read_log(log).flight, names).axes
    assert [line.get_label() for line in speeds.get_lines()] == names[:2]
    assert len(thrusts.get_lines()) == 4
    assert (speeds.get_ylabel(), thrusts.get_ylabel(), places.get_ylabel()) == (
        "[m/s]",
        "[N]",
        "[m]",
    )


def test_fields_are_drawn_where_it_is_asked_for(run, log, out):
    said = run("plot", log, "velocity_data.v_x", "velocity_data", "--save", out / "v.png")
    assert said.code == 0, said.err
    assert [path.name for path in out.iterdir()] == ["v.png"]


def test_an_expression_is_drawn_with_its_unit(log):
    flight = read_log(log).flight
    roll = flight["position_data.roll"].values.astype(float)
    (speeds, angles) = plot_fields(flight, ["v_x/2 + v_y [m/s]", "deg(roll) [deg]"]).axes
    assert (speeds.get_ylabel(), angles.get_ylabel()) == ("[m/s]", "[deg]")
    assert angles.get_lines()[0].get_label() == "deg(roll)"
    np.testing.assert_allclose(angles.get_lines()[0].get_ydata(), np.rad2deg(roll), rtol=1e-12)


def test_spectra_are_those_of_scipy(run, log, out):
    flight = read_log(log).flight
    series = flight["velocity_data.v_z"]
    (axes,) = plot_spectra(flight, ["velocity_data.v_z"], WelchSettings(averages=2)).axes
    rate = (len(series.time) - 1) / (series.time[-1] - series.time[0])
    size = 2 * (len(series.time) // 3)
    frequency, density = scipy.signal.welch(series.values.astype(float), rate, nperseg=size)
    np.testing.assert_allclose(axes.get_lines()[0].get_xdata(), frequency[1:], rtol=1e-9)
    np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), density[1:], rtol=1e-9, atol=1e-25)
    assert axes.get_ylabel() == "[(m/s)^2/Hz]"
    said = run("plot", log, "velocity_data", "--spectrum", "--save", out / "s.png")
    assert said.code == 0, said.err


def test_the_list_has_fields_with_units(run, log):
    said = run("plot", log, "--list")
    assert said.code == 0
    lines = [line.split() for line in said.out.splitlines()]
    assert lines[0] == ["field", "unit", "messages"]
    count = len(read_log(log).states)
    assert ["velocity_data.v_x", "m/s", str(count)] in lines


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        (["velocity_data.v_y_"], "did you mean 'v_y'"),
        (["velocity_date.v_y"], "did you mean 'velocity_data'"),
        (["drone_state.condition"], "is a text, which cannot be drawn"),
        (["tf"], "too many for a panel"),
        (["2*sqrt(v_x"], "'2*sqrt(v_x', at character 7, '(v_x': no expression here"),
        (["v_w + v_x"], "unknown signal 'v_w'"),
        (["--spectrum"], "--spectrum needs fields"),
        (["velocity_data.v_x", "--spectrum", "--averages", "0"], "average over 1 segment"),
    ],
)
def test_what_cannot_be_drawn_is_refused(refused, log, out, fields, sentence):
    assert sentence in refused("plot", log, *fields, "--save", out / "a.png")
    assert not out.exists()


def test_another_suffix_is_refused(refused, log):
    assert "let its name end in .png" in refused("plot", log, "--save", "a.jpg")


def test_a_log_without_messages_is_refused(refused, tmp_path):
    FlightLog(tmp_path / "a.mcap", (), Scenario(), {}, {}, "x").close()
    assert "nothing to draw" in refused("plot", tmp_path / "a.mcap", "--save", tmp_path / "a.png")
