"""Oracle: python-control's step_info."""

from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.resources import find_model
from workbench.gui.tuning.limits import NUMBER_LIMITS
from workbench.gui.tuning.metric_row import metric_rows, response_headline
from workbench.gui.tuning.number_row import RowState
from workbench.gui.tuning.round_trace import RoundTrace, take_trace
from workbench.gui.tuning.step_part import StepPart, measure_step, step_parts
from workbench.plant.loading import load_vehicle
from workbench.scenario.excitation import Excitation, Shape

TIME = np.arange(0.0, 4.0, 1.0 / 128.0)


def trace_of(response):
    return RoundTrace(
        TIME[: len(response)], response, np.zeros(len(response)), np.full(len(response), 0.7)
    )


def swinging(duration: float) -> np.ndarray:
    system = control.tf([36.0], [1.0, 4.0, 36.0])
    return control.step_response(system, TIME[duration >= TIME]).outputs


def test_a_trace_has_the_tilt_of_the_thrust_and_the_busiest_rotor():
    """The angle between the drone's z and that of W, by SciPy's rotations."""
    time = np.arange(0.0, 3.0, 0.5)
    vehicle = load_vehicle(find_model("dh_drone"))
    roll, pitch = 0.1 * time, 0.3 - 0.2 * time
    streams = {"position_data.roll": roll, "position_data.pitch": pitch, "velocity_data.v_x": time}
    for index, rotor in enumerate(vehicle.rotors):
        streams[f"rotors.speed.{index}"] = rotor.max_rot_velocity * 0.1 * (index + time)

    class Stored:
        def series(self, name, since):
            return time[time >= since], streams[name][time >= since]

    found = take_trace(Stored(), Excitation("x", Shape.STEP, 1.0, 2.0), vehicle, 0.5, 2.0)
    up = Rotation.from_euler("yx", np.column_stack([pitch, roll])).apply([0.0, 0.0, 1.0])
    assert found.time.tolist() == [0.0, 0.5, 1.0, 1.5]
    assert found.response.tolist() == [0.5, 1.0, 1.5, 2.0]
    assert found.tilt == pytest.approx(np.arccos(up[1:5, 2]))
    assert found.rotor_use == pytest.approx(0.1 * (len(vehicle.rotors) - 1 + time[1:5]))


@pytest.mark.parametrize(("before", "level"), [(0.0, 2.0), (-2.0, 2.0), (0.0, -0.3)])
def test_numbers_of_a_flown_step_are_those_of_python_control(before, level):
    part = StepPart(0.5, 3.0, before, level)
    rise = (level - before) * swinging(2.5)
    flown = np.full(len(TIME), before)
    flown[TIME >= 0.5] = level
    flown[64 : 64 + len(rise)] = before + rise
    numbers = measure_step(trace_of(flown), part)
    info = control.step_info(rise, T=TIME[: len(rise)])
    assert numbers.rise_time == pytest.approx(info["RiseTime"])
    assert numbers.settling_time == pytest.approx(info["SettlingTime"])
    assert numbers.overshoot == pytest.approx(info["Overshoot"])
    off = abs(rise[-1] - (level - before)) / abs(level - before) * 100.0
    assert numbers.steady_state_error == pytest.approx(off)
    assert numbers.peak_rotor_use == 0.7


def test_numbers_that_mean_nothing_are_withheld_with_the_reason():
    """Too short to settle, begun while it still moved, and with gains that changed."""
    moving = np.full(len(TIME), -1.6)
    moving[TIME >= 0.5] = -1.6 + 3.6 * swinging(3.5)[: int((TIME >= 0.5).sum())]
    cases = [
        (trace_of(swinging(0.6)), StepPart(0.0, 0.59, 0.0, 1.0), False, "not settled within 0.586"),
        (trace_of(moving), StepPart(0.5, 3.5, -2.0, 2.0), False, "did not begin at rest"),
        (trace_of(swinging(3.5)), StepPart(0.0, 3.0, 0.0, 1.0), True, "parameters changed"),
    ]
    for trace, part, changed, why in cases:
        numbers = measure_step(trace, part, changed=changed)
        assert why in numbers.withheld
        assert np.isnan([numbers.rise_time, numbers.settling_time, numbers.overshoot]).all(), why
        assert numbers.peak_rotor_use == 0.7
        rows = metric_rows(numbers, None, lambda name: 1.0)
        assert rows[0].cells[0].text == "–"
        assert rows[0].cells[0].help == numbers.withheld
        assert rows[0].state is RowState.NONE
    assert measure_step(trace_of(swinging(3.5)), StepPart(0.0, 3.0, 0.0, 1.0)).withheld == ""


def test_flown_and_predicted_numbers_are_judged_apart():
    """The flown one of a first-order lag is slow and has no overshoot; the predicted one has."""
    lag = 1.0 - np.exp(-TIME[TIME <= 3.0] / 0.4)
    part = StepPart(0.0, 3.0, 0.0, 1.0)
    flown, predicted = (
        measure_step(trace_of(lag), part),
        measure_step(trace_of(swinging(3.0)), part),
    )
    limits = {"rise_time": 0.5, "overshoot": 10.0}
    rows = metric_rows(flown, predicted, lambda name: limits.get(name, 100.0))
    states = {row.label: [cell.state for cell in row.cells[:2]] for row in rows}
    assert states["Rise time"] == [RowState.OVER, RowState.GOOD]  # 0.88 s: 2.2 time constants
    assert states["Overshoot"] == [RowState.GOOD, RowState.OVER]  # 33 % at a damping of 1/3
    said = "Flown 3 s ago: rise time over the limit. Predicted: overshoot over the limit."
    assert response_headline(rows, "3 s ago") == said
    unknown = replace(predicted, peak_rotor_use=np.nan)  # a linear model has no rotors
    alone = metric_rows(None, unknown, lambda name: 100.0)
    assert response_headline(alone) == "Flown: nothing yet. Predicted: all limits hold."


def test_numbers_are_shown_and_limited_in_the_units_of_screens():
    """Half a radian is 28.65°; a factor of 2, or of a half, is 6.02 dB."""
    shown = {
        "peak_angle": (0.5, 28.648),
        "peak_rate": (0.5, 28.648),
        "peak_rotor_use": (0.5, 50.0),
        "gain_margin": (2.0, 6.021),
        "gain_reduction_margin": (0.5, 6.021),
        "phase_margin": (0.5, 28.648),
        "delay_margin": (0.5, 500.0),
    }
    for limit in NUMBER_LIMITS:
        value, wanted = shown.get(limit.name, (0.5, 0.5))
        assert limit.shown(value) == pytest.approx(wanted, rel=1e-4), limit.name
        assert limit.keeps(value, wanted - 0.001) is limit.at_least, limit.name
        assert limit.keeps(value, wanted + 0.001) is not limit.at_least, limit.name


def test_a_step_that_is_not_over_has_no_numbers():
    part = StepPart(0.0, 3.0, 0.0, 1.0)
    assert measure_step(trace_of(swinging(2.9)), part) is None
    assert measure_step(trace_of(swinging(3.0)), part) is not None


def test_what_comes_after_a_step_does_not_count():
    part = StepPart(0.0, 3.0, 0.0, 1.0)
    flown = np.concatenate([swinging(3.0), np.zeros(100)])
    assert measure_step(trace_of(flown), part) == measure_step(trace_of(swinging(3.0)), part)


def test_the_first_half_of_a_square_wave_goes_all_the_way_once_it_repeats():
    wave = Excitation("x", Shape.SQUARE, 1.5, 2.0, repeats=True)
    assert step_parts(wave)[0] == StepPart(0.0, 1.0, 0.0, 1.5)
    assert step_parts(wave, again=True)[0] == StepPart(0.0, 1.0, -1.5, 1.5)
    assert step_parts(wave)[1] == StepPart(1.0, 2.0, 1.5, -1.5)


def test_a_chirp_has_no_steps():
    assert step_parts(Excitation("x", Shape.CHIRP, 1.0, 5.0)) == ()


@pytest.mark.parametrize("shape", [Shape.STEP, Shape.DOUBLET, Shape.SQUARE])
def test_steps_begin_where_the_command_jumps(shape):
    excitation = Excitation("x", shape, 1.0, 2.0)
    for part in step_parts(excitation):
        assert part.begin in excitation.edges
        assert excitation.command(part.begin + 0.01) == part.level
        assert excitation.command(part.end - 0.01) == part.level


def test_a_step_that_lacks_a_sample_is_not_measured_yet():
    part = StepPart(0.0, 2.0, 0.0, 1.0)
    whole = trace_of(swinging(2.0))
    assert whole.time[-1] == 2.0
    assert measure_step(whole.only(slice(0, -1)), part) is None
    assert measure_step(whole, part) is not None
