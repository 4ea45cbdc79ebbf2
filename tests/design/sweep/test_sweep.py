"""Oracle: `fly_step` on the full diagram, and what must hold of any sweep."""

import dataclasses

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.metrics import FLOWN_METRICS
from workbench.design.step_response import fly_step
from workbench.design.sweep import full_flights
from workbench.design.sweep.best import (
    MAX_PROVED_CANDIDATES,
    prove_best,
    unaffected_numbers_text,
    why_no_best,
)
from workbench.design.sweep.case import (
    SweepCandidate,
    SweepCase,
    default_axis,
    empty_results,
)
from workbench.design.sweep.full_flights import fly_full, fly_one, loss_time
from workbench.design.sweep.sweep import sweep
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig

NAN = float("nan")


def full(settings, **options):
    """Return the metrics of `fly_step`, in the order of a sweep."""
    response = fly_step("x", 1.0, settings=settings, **options)
    return [*response.metrics.numbers.values(), response.peak_rotor_use]


def test_a_row_is_what_fly_step_measures(lost_table):
    kp_pitch, kp_velocity_x = lost_table.parameters[1]
    expected = full({"kp_pitch": kp_pitch, "kp_velocity_x": kp_velocity_x})
    np.testing.assert_allclose(lost_table.values[1], expected, rtol=2e-3, atol=1e-3)
    np.testing.assert_allclose(lost_table.present_values, full({}), rtol=2e-3, atol=1e-3)
    assert lost_table.present.tolist() == [225.0, 4.45]


def test_what_diverges_is_a_row_with_its_time(lost_table):
    assert len(lost_table) == lost_table.planned == 6
    lost = np.isfinite(lost_table.diverged_at)
    assert lost.tolist() == [False, False, True, True, True, True]  # the stiffest
    assert ((lost_table.diverged_at[lost] >= 0.0) & (lost_table.diverged_at[lost] <= 3.0)).all()
    assert np.isnan(lost_table.values[lost]).all()


@pytest.mark.slow
def test_the_full_diagram_loses_the_same_candidates_at_the_same_time(lost_table):
    index = int(np.flatnonzero(np.isfinite(lost_table.diverged_at))[0])
    values, lost = fly_one(lost_table.case, lost_table.candidate(index))
    assert lost == pytest.approx(lost_table.diverged_at[index], abs=0.05)
    assert np.isnan(values).all()


@pytest.mark.slow
def test_processes_fly_what_the_compiled_engine_flies(lost_table):
    case = lost_table.case
    table = sweep(
        ["kp_pitch=100..2000:2"],
        axis="x",
        amplitude=1.0,
        fly=fly_full,
        settings={"kp_velocity_x": 3.0},
    )
    same = [0, 4]
    np.testing.assert_allclose(table.values, lost_table.values[same], rtol=2e-3, atol=1e-3)
    np.testing.assert_allclose(table.diverged_at, lost_table.diverged_at[same], atol=0.05)
    assert case.settings == {}


def test_variations_rotors_and_air_act():
    table = sweep(["vary.mass=0.8..1.25:3"], duration=1.0)
    use = table.column("peak_rotor_use")
    assert (np.diff(use) > 0.01).all()
    scenario = Scenario(vehicle=VehicleConfig(variation=Variation(mass=1.25)))
    assert use[2] == pytest.approx(
        fly_step("z", 1.0, duration=1.0, scenario=scenario).peak_rotor_use
    )
    for text in ("rotor_1=0.7..1:2", "wind_x=0..6:2", "drag_area=0..0.2:2"):
        table = sweep([text], axis="x", amplitude=2.0, duration=1.0)
        assert abs(np.diff(table.column("peak"))[0]) > 1e-3, text


@pytest.mark.slow
def test_on_an_estimate_filters_delays_noise_and_the_filter_itself_act(caplog):
    """Compiled, which takes minutes; test_agreement.py flies on estimates uncompiled."""
    scenario = Scenario(estimator="ekf")
    for text in (
        "gyro_lowpass=15..100:2",
        "vary.sensing_delay=0..0.02:2",
        "ekf_gps_velocity=0.05..2:2",
        "seed=1..2:2",
    ):
        table = sweep([text], axis="x", amplitude=2.0, duration=1.0, scenario=scenario)
        assert abs(np.diff(table.column("peak"))[0]) > 1e-4, text
    # until the step has settled: a flight of 1 s has no rise time
    table = sweep(["seed=1..2:2"], axis="x", amplitude=2.0, scenario=scenario)
    flown = fly_step("x", 2.0, scenario=scenario)
    assert table.present_values[0] == pytest.approx(flown.metrics.rise_time, abs=1e-9)
    assert "full diagram" not in caplog.text


@pytest.mark.slow
def test_what_is_not_compiled_of_a_flight_on_an_estimate_flies_on_the_full_diagram(caplog):
    scenario = Scenario(estimator="ekf")
    with pytest.raises(
        WorkbenchError, match=r"is swept without effect, because .* truth: add --estimator"
    ):
        sweep(["ekf_gate=2..4:2"], duration=0.2)
    iron = {"magnetometer_disturbance_x": 1e-5}
    sweep(
        ["kp_roll=200..300:2"],
        axis="y",
        amplitude=2.0,
        duration=0.2,
        scenario=scenario,
        settings=iron,
        stop=lambda: True,
    )
    assert "magnetometer_disturbance_x, which flights on ekf feel, is not compiled" in caplog.text


def test_a_scenarios_gains_and_variation_hold_for_all(tmp_path):
    path = tmp_path / "soft.yaml"
    path.write_text("gains: {kp_velocity_z: 2.0}\n")
    scenario = Scenario(vehicle=VehicleConfig(gains=str(path), variation=Variation(mass=1.1)))
    table = sweep(
        ["kd_velocity_z=0..0.2:2", "vary.inertia=1..2:2"], scenario=scenario, duration=1.0
    )
    assert table.present[1] == 1.0
    expected = fly_step("z", 1.0, duration=1.0, scenario=scenario, settings={"kd_velocity_z": 0.0})
    assert table.column("peak")[0] == pytest.approx(expected.metrics.peak, abs=0.01)
    assert table.candidate(1).variation == Variation(mass=1.1, inertia=2.0)


def test_a_stopped_sweep_keeps_what_was_flown():
    count = 0

    def stop():
        nonlocal count
        count += 1
        return count >= 2

    shares = []
    table = sweep(["kp_velocity_z=2..10:200"], duration=2.5, stop=stop, progress=shares.append)
    assert 0 < len(table) < table.planned == 200
    assert np.isfinite(table.column("rise_time")).any()
    np.testing.assert_array_equal(
        table.column("kp_velocity_z"), np.linspace(2.0, 10.0, 200)[: len(table)]
    )
    assert shares == sorted(shares)
    assert shares[-1] < 1.0


@pytest.mark.slow
def test_a_stopped_sweep_in_processes_keeps_what_was_flown(monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0})  # one process is enough
    table = sweep(["kp_velocity_z=2..10:30"], duration=0.2, fly=fly_full, stop=lambda: True)
    assert len(table) < 30


def test_margins_are_columns():
    table = sweep(["kp_velocity_x=2..6:2", "kp_pitch=100..2000:2"], axis="x", loop="velocity_x")
    assert table.names[-5:] == (
        "phase_margin",
        "gain_margin",
        "delay_margin",
        "disk_margin",
        "diverged_at",
    )
    phase = table.column("phase_margin")
    lost = np.isfinite(table.diverged_at)
    assert np.isnan(phase[lost]).all()
    assert np.isfinite(phase[~lost]).all()
    assert phase[0] > phase[2]  # a faster loop has less
    assert table.ranking("phase_margin")[0] == 0


def test_margins_of_another_loop_follow_its_gains():
    table = sweep(["kp_velocity_x=2..6:2"], axis="x", loop="roll", duration=0.5)
    first, second = table.column("delay_margin")
    assert first == pytest.approx(second, rel=1e-6)


def test_what_is_no_sweep_is_a_sentence_before_anything_flies(case):
    for options, said in [
        ({"axis": "w"}, "unknown axis"),
        ({"amplitude": 0.0}, "amplitude"),
        ({"amplitude": NAN}, "amplitude"),
        ({"amplitude": 50.0}, "raise max_speed"),
        ({"duration": 0.0}, "0.1 s or more"),
        ({"method": "grit"}, "did you mean 'grid'"),
        ({"loop": "rol"}, "did you mean 'roll'"),
        ({"settings": {"kp_rol": 1.0}}, "did you mean 'kp_roll'"),
        ({"ranges": ["rotor_5=0..1"]}, "has 4 rotors"),
        ({"ranges": ["max_climb_rate=0.5..5"]}, "within ±0.5"),
        ({"scenario": Scenario(vehicle=VehicleConfig(model="gone"))}, "unknown model"),
    ]:
        with case(options, said):

            def fly(*_):
                raise AssertionError("it flew")

            with pytest.raises(WorkbenchError) as caught:
                sweep(**{"ranges": ["kp_roll=100..200:2"], "fly": fly} | options)
            assert said in str(caught.value)


@pytest.mark.slow
def test_the_best_is_flown_on_the_full_diagram(lost_table):
    best = prove_best(lost_table, "rise_time")
    assert best.index == lost_table.ranking("rise_time")[0]
    settings = dict(zip(("kp_pitch", "kp_velocity_x"), best.parameters, strict=True))
    assert best.flown.tolist() == full(settings)
    np.testing.assert_allclose(best.difference, 0.0, atol=2e-3)
    assert best.refused == ()


def test_a_best_that_is_lost_on_the_full_diagram_is_refused(lost_table, monkeypatch):
    order = lost_table.ranking("rise_time")
    lost = [lost_table.candidate(index) for index in order[:1]]

    def fly(case, candidate):
        return (
            ([NAN] * len(FLOWN_METRICS), 0.5)
            if candidate in lost
            else ([1.0] * len(FLOWN_METRICS), NAN)
        )

    monkeypatch.setattr(full_flights, "fly_one", fly)
    best = prove_best(lost_table, "rise_time")
    assert best.index == order[1]
    assert best.refused == tuple(order[:1])
    monkeypatch.setattr(full_flights, "fly_one", lambda *_: ([NAN] * len(FLOWN_METRICS), 0.5))
    assert prove_best(lost_table, "rise_time") is None
    assert MAX_PROVED_CANDIDATES == 5


def test_what_the_controller_does_not_know_of_cannot_be_the_best(monkeypatch):
    monkeypatch.setattr(full_flights, "fly_one", lambda *_: ([1.0] * len(FLOWN_METRICS), NAN))
    table = sweep(["kp_velocity_z=2..6:2", "vary.mass=0.9..1.1:2"], duration=0.5)
    assert prove_best(table, "rise_time") is None
    with pytest.raises(WorkbenchError, match="unknown metric"):
        prove_best(table, "rise_tim")


def test_the_axis_follows_the_gains_and_equal_candidates_have_no_best():
    """Gains of the pitch loop do nothing in a climb, and roll's nothing along x."""
    gains = ["kp_pitch=100..400:3", "kd_pitch=15..45:3"]
    along_x = sweep(gains, duration=2.0)
    assert along_x.case.axis == "x"
    assert along_x.unmoved("overshoot") == ()
    climb = sweep(gains, axis="z", duration=2.0)
    assert climb.unmoved("overshoot") == ("kp_pitch", "kd_pitch")
    assert len(climb.tied("overshoot")) == 9
    assert prove_best(climb, "overshoot") is None
    assert why_no_best(climb, "overshoot") == (
        "no best is chosen: all 9 candidates have the same overshoot, 0 %: kp_pitch and kd_pitch "
        "do not move overshoot on axis z; try --axis x"
    )
    mixed = sweep(["kp_velocity_x=2..6:3", "kp_roll=100..400:4"], duration=3.0)
    assert mixed.unmoved("rise_time") == ("kp_roll",)
    best = prove_best(mixed, "rise_time")
    assert best.unmoved == ("kp_roll",)
    assert best.parameters.tolist() == [6.0, 200.0]  # of equal ones the nearest to the present 225
    assert unaffected_numbers_text(mixed, "rise_time").startswith("kp_roll does not move rise_time")
    axes = {"kp_roll": "y", "kp_yaw_rate": "yaw", "kd_velocity_z": "z", "seed": "z", "wind_y": "y"}
    assert {name: default_axis([name]) for name in axes} == axes


def test_present_values_that_rank_before_the_best_are_better(make_table):
    """Columns are those of `FLOWN_METRICS`; the eighth is the error, of which 5 % is the limit."""
    row = [0.3, 0.9, 1.0, 0.0, 2.0, 0.5, 2.0, 1.0, 0.5]
    slower, away = [0.4, *row[1:]], [0.1, *row[1:7], 6.0, 0.5]
    for present, best, better in (
        (row, slower, True),
        (slower, row, False),
        (row, row, False),
        (row, away, True),  # quicker, but too far from the command
        ([NAN] * 9, row, False),
    ):
        table = make_table([best, best], [NAN, NAN], "kp_roll=100..400:2")
        table = dataclasses.replace(table, present_values=np.array(present))
        assert table.present_is_better("rise_time", 1) == better, (present, best)
        assert table.missed.tolist() == [best is away] * 2


def test_a_candidate_that_has_not_settled_is_no_best():
    table = sweep(["kp_velocity_z=0.5..6:4"], duration=4.0)
    assert table.withheld.tolist() == [True, False, False, False]
    assert np.isnan(table.column("steady_state_error")[0])
    for metric in ("rise_time", "overshoot", "peak_rotor_use"):
        assert 0 not in table.ranking(metric)
    short = sweep(["kp_velocity_z=2..6:3"], duration=0.5)
    assert prove_best(short, "peak_rotor_use") is None
    assert "no candidate settles within 0.5 s" in why_no_best(short, "peak_rotor_use")


@pytest.mark.slow
def test_in_wind_every_way_of_a_sweep_begins_where_the_step_command_does():
    """The drift of `pd` is no error of its step."""
    case = SweepCase("x", 1.0, 2.0)
    table = sweep(["wind_x=0..6:2"], axis="x", amplitude=1.0, duration=2.0)
    assert (table.column("steady_state_error") < 2.0).all()
    values, lost = fly_one(case, SweepCandidate({"wind_x": 6.0}, Variation()))
    assert np.isnan(lost)
    np.testing.assert_allclose(table.values[1], values, atol=1e-6)
    np.testing.assert_allclose(values, full({"wind_x": 6.0}, duration=2.0), atol=1e-9)


def test_nothing_flown_is_all_unknown():
    flown = empty_results(3)
    assert not flown.done.any()
    assert np.isnan(flown.values).all()
    assert np.isnan(flown.diverged_at).all()


def test_lost_is_lost_by_the_same_rule_as_in_the_engine():
    recording = fly_step("z", 1.0, duration=0.5).recording
    assert np.isnan(loss_time(recording))

    def changed(**arrays):
        new = {}
        for name, (index, value) in arrays.items():
            new[name] = getattr(recording, name).copy()
            new[name][index:] = value
        return loss_time(dataclasses.replace(recording, **new))

    middle = int(np.flatnonzero(recording.time >= 1.25)[0])
    at = pytest.approx(recording.time[middle] - 1.0)
    upside_down = (middle, [0.0, 1.0, 0.0, 0.0])
    assert np.isnan(changed(q_WB=upside_down))
    assert changed(q_WB=upside_down, w_WB=(middle, [0.0, 11.0, 0.0])) == at
    assert changed(q_WB=upside_down, v_WB=(middle, [0.0, 0.0, -21.0])) == at
    assert np.isnan(changed(w_WB=(middle, [0.0, 11.0, 0.0])))
    assert changed(p_WB=(middle, [0.0, 0.0, 0.01])) == at
    assert changed(v_WB=(middle, [np.inf, 0.0, 0.0])) == at
    assert changed(p_WB=(0, [0.0, 0.0, 0.01])) == 0.0  # before the edge


def test_a_case_can_be_sent_to_a_process():
    import pickle

    case = SweepCase("x", 2.0, settings={"kp_roll": 1.0})
    assert pickle.loads(pickle.dumps(case)) == case
