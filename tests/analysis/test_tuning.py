"""Searches: what is found holds in a flight of its own."""

import dataclasses
import shutil
import threading
from pathlib import Path

import pytest
import yaml

from workbench.analysis import tuning
from workbench.analysis.queries import RegressionCase, RequestedStep, Tune
from workbench.analysis.subject import AnalysedVehicle
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.common.resources import models_dir
from workbench.design.judge.loop_judgement import hover_margins
from workbench.design.linear.study import LinearStudy
from workbench.design.pin import pin_step
from workbench.design.regress.flight import Changes
from workbench.design.regress.running import regress
from workbench.design.step_response import fly_step
from workbench.design.tune.case import NOMINAL_CASE
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.tuning import Tuning, WishResult
from workbench.design.tune.wish import GUARD_ORIGIN, parse_wish
from workbench.gains.gains import load_gains
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Rates, Scenario, VehicleConfig

GAINS = {"kp_pitch": 180.0, "kd_pitch": 24.0}
STEP = RequestedStep("x", 2.0, 2.0)


@pytest.fixture(scope="module")
def found(subject):
    """A search and all that it told."""
    from workbench.analysis.tuning import tune_gains

    told = []

    class Listening:
        def on_stop(self, act):
            pass

        def tell(self, searched):
            told.append(searched)

    return next(tune_gains(subject, Tune({}, ("x.rise_time <= 0.3",)), Listening())), told


@pytest.mark.slow
def test_gains_that_are_found_fly_as_wished(found):
    tuned, _ = found
    assert tuned.met
    flown = fly_step("x", 1.0, duration=2.0, settings=tuned.gains)
    assert flown.metrics.rise_time <= 0.3
    assert flown.metrics.overshoot <= 5.0
    assert tuned.before.keys() == tuned.gains.keys()
    assert tuned.before["kp_velocity_x"] != tuned.gains["kp_velocity_x"]


@pytest.mark.slow
def test_each_wish_is_shown_before_and_after(found):
    tuned, _ = found
    before, after, met = next(
        rest for wish, *rest in tuned.wishes if wish == "x.rise_time <= 0.3 s"
    )
    assert met
    assert before.endswith(" s")
    assert float(before.split()[0]) > 0.3 >= float(after.split()[0])


@pytest.mark.slow
def test_the_steps_are_there_to_be_looked_at(found):
    tuned, _ = found
    time, before, after = tuned.steps["x"]
    assert len(time) == len(before) == len(after) > 100
    assert after[-1] == pytest.approx(1.0, abs=0.05)
    assert not (before == after).all()


@pytest.mark.slow
def test_it_tells_how_it_goes(found):
    _, told = found
    assert [each.share for each in told] == sorted(each.share for each in told)
    assert 0.0 < told[-1].share <= 1.0
    assert told[-1].gains["kp_velocity_x"] > 0.0
    first = next(each for each in told if each.said)
    assert first.said.startswith("y.rise_time 0.3")
    assert first.said.endswith("% short")


@pytest.mark.slow
def test_it_says_what_it_does_and_is_never_full_before_the_end(found):
    _, told = found
    phases = [each.phase for each in told]
    stages = [
        "flying the law's own gains",
        "linear model of vehicle 1 of 8",
        "searching",
    ]
    stages += ["proving on the full diagram: x step 1 of", "flying the steps for the report"]
    places = [next(i for i, phase in enumerate(phases) if phase.startswith(s)) for s in stages]
    assert places == sorted(places)
    assert max(each.share for each in told) < 1.0
    proof = [each.share for each in told if each.phase.startswith("proving")]
    assert len(set(proof)) > 10  # it moves while a flight is flown


@pytest.mark.slow
def test_a_stop_keeps_the_best_so_far_and_says_so(subject):
    from workbench.analysis.tuning import tune_gains

    class Impatient:
        def on_stop(self, act):
            self.act = act

        def tell(self, _):
            threading.Thread(target=self.act).start()

    wishes = ("x.rise_time <= 0.1", "pitch.phase_margin >= 70deg")
    tuned = next(tune_gains(subject, Tune({}, wishes), Impatient()))
    assert tuned.stopped
    assert not tuned.met
    assert any("stopped early" in said for said in tuned.said)


def carrying(model, **settings):
    """Return a subject whose payload, hooks or servos have changed in flight."""
    return AnalysedVehicle(Scenario(vehicle=VehicleConfig(model=model)), settings)


def test_gains_are_searched_for_the_vehicle_as_it_flies(answer, monkeypatch):
    """`slung_load` is `dh_drone` with a load; of the others the setup has the settings."""
    tuners = []

    class Recorded(tuning.Tuner):
        def run(self, _):
            tuners.append(self)
            raise WorkbenchError("enough")

    monkeypatch.setattr(tuning, "Tuner", Recorded)
    moved = {"servo_shoulder": 0.9, "servo_elbow": -1.8}
    for about in (
        carrying("slung_load", open_hooks=1.0),
        carrying("dh_drone"),
        carrying("dh_drone", payload_mass=0.5),
        carrying("manipulator", **moved),
    ):
        with pytest.raises(WorkbenchError, match="enough"):
            answer(Tune({}, ()), about)
    dropped, bare, heavy, arm = (each._setup for each in tuners)
    margins, truth = (hover_margins(LinearStudy(each).sampled()) for each in (dropped, bare))
    for loop in truth:
        assert margins[loop].phase_margin == pytest.approx(truth[loop].phase_margin, rel=1e-6)
    assert dropped.with_settings(dropped.values).flown_vehicle.mass == bare.flown_vehicle.mass
    assert heavy.values["payload_mass"] == 0.5
    assert {name: arm.values[name] for name in moved} == moved


def test_a_margin_that_no_wish_is_about_is_told_where_it_falls(answer, monkeypatch):
    def result(text, before, after):
        (wish,) = parse_wish(text)
        guard = dataclasses.replace(wish, origin=GUARD_ORIGIN)
        return WishResult(Requirement(guard, NOMINAL_CASE, guard.bound), before, after)

    falls = result("pitch.disk_margin>=0.5", 0.9, 0.8)
    rises = result("roll.disk_margin>=0.5", 0.8, 0.9)

    class Found(tuning.Tuner):
        def run(self, _):
            named = {each.name: () for each in dataclasses.fields(Tuning)}
            given = {"results": (falls, rises), "responses": {}, "proof": None, "stopped": False}
            return Tuning(**named | given)

    monkeypatch.setattr(tuning, "Tuner", Found)
    said = [each for each in answer(Tune({}, ())).said if "no wish" in each]
    assert said == ["pitch.disk_margin, about which there is no wish, falls: 0.9 to 0.8"]


def test_margins_are_pinned_with_the_payload(answer, tmp_path):
    """A spec computes them without the settings of its cases."""
    about = carrying("dh_drone", payload_mass=0.5, open_hooks=0.0)
    assert about.vehicle_settings == {"payload_mass": 0.5}
    path = tmp_path / "heavy.workbench.yaml"
    answer(RegressionCase(path, {}, RequestedStep("x", 1.0, 0.5)), about)
    low, high = yaml.safe_load(path.read_text())["margins"]["velocity_x"]["crossover"]
    heavy, bare = (
        hover_margins(LinearStudy(each.setup).sampled())["velocity_x"].crossover
        for each in (about, carrying("dh_drone"))
    )
    assert low < heavy < high < bare


def test_bad_wishes_and_a_varied_vehicle_are_refused(answer):
    with pytest.raises(WorkbenchError, match="is not a wish"):
        answer(Tune({}, ("fly well",)))
    heavy = Scenario(vehicle=VehicleConfig(variation=Variation(mass=1.2)))
    with pytest.raises(WorkbenchError, match="varies the vehicle on its own"):
        answer(Tune({}, ()), AnalysedVehicle(heavy, {}))


@pytest.fixture(scope="module")
def pinned(tmp_path_factory):
    """A pinned step, not to be changed."""
    path = tmp_path_factory.mktemp("pinned") / "mine.workbench.yaml"
    return pin_step(path, Scenario(), GAINS, "x", 2.0, duration=2.0)


def passed(path, changes=None):
    return [result.passed for result in regress([path], changes)]


def test_it_is_green_at_once_on_the_command_line(pinned, capsys):
    assert main(["regress", str(pinned.spec), "-j", "1"]) == 0, capsys.readouterr()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kp_velocity_x", "kd_velocity_x", "kp_pitch", "kd_pitch"])
def test_it_is_red_with_a_gain_of_its_loops_of_seven_tenths(pinned, name):
    value = load_gains(pinned.gains).gains[name]
    assert not all(passed(pinned.spec, Changes(settings={name: 0.7 * value})))


@pytest.mark.parametrize("step", [1 / 512, 1 / 2048])
def test_it_bears_half_and_twice_the_integrators_step(pinned, step):
    assert all(passed(pinned.spec, Changes(physics_step=step)))


def test_the_numbers_are_in_it_and_limits_have_room_on_both_sides(pinned):
    said = yaml.safe_load(pinned.spec.read_text())
    assert load_gains(pinned.gains).gains["kp_pitch"] == 180.0
    assert said["vehicle"] == {"model": "dh_drone", "gains": "mine.gains.yaml"}
    (case,) = said["cases"]
    (result, *_) = regress([pinned.spec])
    rise = next(each.value for each in result.checks if each.name == "rise_time")
    low, high = case["limits"]["rise_time"]
    assert 0.8 * rise < low < 0.9 * rise
    assert 1.1 * rise < high < 1.2 * rise
    assert set(case["baseline"]) == {"v_x", "p_x"}
    assert len(said["margins"]) == pinned.loops == 9
    assert said["margins"]["roll"]["crossover"][0] < said["margins"]["roll"]["crossover"][1]


def test_who_stops_it_at_the_last_moment_finds_no_file(tmp_path):
    def stop(share):
        if share == 1.0:
            raise WorkbenchError("it was stopped")

    path = tmp_path / "a.workbench.yaml"
    with pytest.raises(WorkbenchError, match="stopped"):
        pin_step(path, Scenario(), {}, "x", 1.0, duration=1.0, margins=False, progress=stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_gain_file_beside_the_model_may_change_later(tmp_path):
    """The model's own gains.yaml is edited after the pin: the pinned step still flies as it did."""
    model = tmp_path / "models" / "drone"
    shutil.copytree(models_dir() / "dh_drone", model)
    scenario = Scenario(vehicle=VehicleConfig(model=str(model / "drone.urdf.xacro")))
    spec = pin_step(tmp_path / "specs/a.workbench.yaml", scenario, {}, "z", 1.0, duration=2.0).spec
    said = yaml.safe_load(spec.read_text())
    assert said["vehicle"]["model"] == "../models/drone/drone.urdf.xacro"
    own = model / "gains.yaml"
    text = own.read_text() if own.is_file() else "vehicle: dh_drone\ngains: {kp_velocity_z: 4}\n"
    content = yaml.safe_load(text)
    content["gains"]["kp_velocity_z"] = 2.0
    own.write_text(yaml.safe_dump(content))
    assert all(passed(spec))
    moved = tmp_path.with_name("moved")
    tmp_path.rename(moved)
    assert all(passed(moved / "specs/a.workbench.yaml"))
    moved.rename(tmp_path)


@pytest.mark.slow
def test_variation_and_rates_are_pinned_too_and_margins_may_be_left_out(tmp_path):
    scenario = Scenario(
        world="obstacle_field",
        vehicle=VehicleConfig(variation=Variation(mass=1.1)),
        rates=Rates(control_period=1 / 64, record_period=1 / 64),
    )
    path = tmp_path / "heavy.workbench.yaml"
    found = pin_step(path, scenario, {}, "yaw", -0.2, duration=1.5, margins=False)
    said = yaml.safe_load(path.read_text())
    assert said["vehicle"]["variation"] == {"mass": 1.1}
    assert said["rates"]["control_period"] == 1 / 64
    assert "margins" not in said
    assert "world" not in said
    assert found.loops == 0
    assert all(passed(path))


@pytest.mark.slow
def test_other_parameters_than_the_controllers_are_set_in_the_case(tmp_path):
    path = tmp_path / "windy.workbench.yaml"
    pin_step(path, Scenario(), {"wind_y": 4.0}, "x", 1.0, duration=1.5, margins=False)
    assert yaml.safe_load(path.read_text())["cases"][0]["set"] == {"wind_y": 4.0}
    assert not all(passed(path, Changes(settings={"wind_y": 0.0})))


def test_files_that_are_there_stay_unless_asked_otherwise(tmp_path):
    path = tmp_path / "a.workbench.yaml"
    path.write_text("precious")
    with pytest.raises(WorkbenchError, match="exists already: take another name, or overwrite"):
        pin_step(path, Scenario(), {}, "x", 1.0)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]
    pin_step(path, Scenario(), {}, "x", 1.0, duration=1.0, margins=False, overwrite=True)
    assert all(passed(path))


@pytest.mark.parametrize(
    ("name", "gains", "axis", "said"),
    [
        ("a.yaml", {}, "x", "name it NAME.workbench.yaml"),
        ("a.workbench.yaml", {"kp_pitch": -1.0}, "x", "kp_pitch is -1"),
        (
            "a.workbench.yaml",
            {"kp_pitch": 2500.0, "kd_pitch": 0.5},
            "x",
            "cannot be pinned: the flight",
        ),
        ("a.workbench.yaml", {"kp_roll": 1500.0}, "z", "cannot be pinned"),
        ("a.workbench.yaml", {}, "up", "unknown axis 'up'"),
    ],
)
def test_nothing_is_written_of_what_cannot_be_pinned(tmp_path, name, gains, axis, said):
    with pytest.raises(WorkbenchError, match=said):
        pin_step(tmp_path / name, Scenario(), gains, axis, 2.0, duration=2.0)
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_green_when_it_was_written_is_taken_back(tmp_path, monkeypatch):
    from workbench.design import pin

    def fail(path, controller):
        raise WorkbenchError(f"{path}: what was pinned fails")

    monkeypatch.setattr(pin, "_prove", fail)
    path = tmp_path / "a.workbench.yaml"
    with pytest.raises(WorkbenchError, match="what was pinned fails"):
        pin_step(path, Scenario(), {}, "x", 1.0, duration=1.0, margins=False)
    assert list(tmp_path.iterdir()) == []
    path.write_text("old")
    with pytest.raises(WorkbenchError, match="what was pinned fails"):
        pin_step(path, Scenario(), {}, "x", 1.0, duration=1.0, margins=False, overwrite=True)
    assert path.read_text() == "old"


def test_a_folder_that_cannot_be_made_is_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(WorkbenchError, match="cannot be made"):
        pin_step(tmp_path / "file/a.workbench.yaml", Scenario(), {}, "x", 1.0, margins=False)


def test_the_answer_says_what_is_held_and_settings_count(answer, tmp_path):
    path = tmp_path / "b.workbench.yaml"
    about = AnalysedVehicle(Scenario(), {"kp_pitch": 200.0, "wind_x": 3.0})
    spec, baseline, said = answer(
        RegressionCase(path, {"kd_pitch": 25.0}, STEP, margins=False), about
    )
    assert spec == path
    assert baseline == Path(tmp_path / "b.baseline")
    assert baseline.is_dir()
    assert said == "8 numbers and 2 curves of a step along x are pinned to the present values"
    kept = load_gains(tmp_path / "b.gains.yaml").gains
    assert (kept["kp_pitch"], kept["kd_pitch"]) == (200.0, 25.0)
