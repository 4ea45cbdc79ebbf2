"""Reading specs: what is understood, and what is refused with file and line."""

import math

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import (
    controllers_dir,
    find_spec,
    list_models,
    list_specs,
    specs_dir,
)
from workbench.design.regress.loading import load_spec
from workbench.design.regress.spec import SpecLimit, Tolerance
from workbench.design.regress.spec_names import find_specs, part_names

STEP = """\
cases:
  - name: up
    axis: z
    amplitude: 1
    {0}
"""
SCRIPT = """\
cases:
  - name: there
    edge: 1
    signal: p_x
    script: [{{at: 1, go_to: [1, 0, 2]}}]
    {0}
"""


@pytest.fixture
def spec(tmp_path):
    def write(text: str):
        path = tmp_path / "s.workbench.yaml"
        path.write_text(text)
        return path

    return write


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        load_spec(path)
    return str(caught.value)


def test_limits_are_two_sided_or_open_and_may_be_short(spec):
    text = "limits: {rise_time: [0.3, 0.4], overshoot: {max: 5}, peak: {min: 0.9, max: 1.1}}"
    case = load_spec(spec(STEP.format(text))).content.cases[0]
    assert case.limits == {
        "rise_time": SpecLimit(0.3, 0.4),
        "overshoot": SpecLimit(-math.inf, 5.0),
        "peak": SpecLimit(0.9, 1.1),
    }


def test_a_baseline_has_tolerances_by_signal(spec):
    text = "baseline: {v_z: {absolute: 0.1, time_shift: 0.01}, thrust: {relative: 0.05}}"
    case = load_spec(spec(STEP.format(text))).content.cases[0]
    assert case.baseline == {
        "v_z": Tolerance(absolute=0.1, time_shift=0.01),
        "thrust": Tolerance(relative=0.05),
    }


@pytest.mark.parametrize("text", ["1e-3", "1.e-3", "+1e-3", "1E-3", ".1e-2", "1.0e-3", "0.001"])
def test_numbers_may_have_an_exponent_without_a_point_or_sign(spec, text):
    """YAML 1.1 takes most of these for texts."""
    demands = (
        f"set: {{kp_roll: 2e2}}\n    limits: {{peak: [{text}, 1e9], rise_time: {{max: {text}}}}}"
    )
    case = load_spec(spec(STEP.format(demands))).content.cases[0]
    assert case.set == {"kp_roll": 200.0}
    assert case.limits == {"peak": SpecLimit(0.001, 1e9), "rise_time": SpecLimit(-math.inf, 0.001)}


@pytest.mark.parametrize("text", ["1e", "e3", "1e3 s", "1_0e3", "nan", "'.'", "1e3.5"])
def test_a_text_is_no_number(spec, text):
    assert "should be a number" in fault(spec(STEP.format(f"limits: {{peak: {{max: {text}}}}}")))


def test_a_text_that_looks_like_a_number_stays_a_text(spec):
    text = "title: 1e5\n" + STEP.format("limits: {peak: {max: 1e9}}")
    assert load_spec(spec(text)).content.title == "1e5"


def test_vehicle_and_gains_are_found_beside_the_spec(spec, tmp_path):
    (tmp_path / "mine.yaml").write_text("gains: {kp_roll: 100}\n")
    text = "vehicle: {model: dh_drone, gains: mine.yaml, args: {mass: '2'}}\n"
    found = load_spec(spec(text + STEP.format("limits: {peak: {max: 2}}"))).content.vehicle
    assert found.gains == str(tmp_path / "mine.yaml")
    assert found.args == {"mass": "2"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("limits: {rise_tim: {max: 1}}", ":5: unknown metric 'rise_tim': did you mean 'rise_time'"),
        ("limits: {meen of v_z: {max: 1}}", ":5: unknown statistic of a signal 'meen': did you"),
        ("limits: {rise_time of v_z: {max: 1}}", ":5: unknown statistic of a signal 'rise_time'"),
        ("limits: {mean of v_u: {max: 1}}", ":5: unknown signal 'v_u': did you mean"),
        ("limits: {rise_time: {most: 1}}", ":5: unknown key 'most'"),
        ("limits: {rise_time: 0.3}", ":5: cases.0.limits.rise_time is 0.3, and should be 'key:"),
        ("limits: {rise_time: [0.4, 0.3]}", ":5: rise_time must have a min, a max no smaller"),
        ("limits: {rise_time: {}}", ":5: rise_time must have a min"),
        ("limits: {rise_time: {max: soon}}", "should be a number"),
        ("baseline: {v_u: {absolute: 1}}", ":5: unknown signal 'v_u': did you mean"),
        ("baseline: {v_x: {}}", ":5: v_x must have an absolute or a relative tolerance"),
        ("baseline: {v_x: {absolute: -1}}", ":5: absolute must be 0 or more"),
        ("set: {kp_rol: 1}", ":5: unknown parameter 'kp_rol': did you mean 'kp_roll'"),
        ("set: {kp_roll: -1}", ":5: kp_roll is -1"),
        ("duration: 0", ":5: duration must be 0.1 s or more"),
        ("duration: 601", ":5: duration must be 0.1 s or more, and 600 s at most"),
        ("script: [{at: 0, velocity: [1, 0, 0]}]", ":5: script belongs to a script"),
        ("command: 1", ":5: command belongs to a script"),
        ("signal: p_x", ":5: signal belongs to a script"),
        ("speed: 1", ":5: unknown key 'speed'"),
        ("", ":2: 'up' checks nothing: give it limits or a baseline"),
    ],
)
def test_a_wrong_step_is_named_with_its_line(spec, text, said):
    path = spec(STEP.format(text))
    assert fault(path).startswith(str(path))
    assert said in fault(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("limits: {rise_time: {max: 1}}", ":6: rise_time needs a signal and a command"),
        ("limits: {mean_force: {max: 1}}", ":6: mean_force needs an axis"),
        ("command: 0", ":6: command must be a finite number, and not 0"),
        ("amplitude: 1", ":6: amplitude belongs to an axis"),
        ("start: {mode: flying}", ":6: start.mode must be one of off, hovering"),
    ],
)
def test_a_wrong_script_is_named_with_its_line(spec, text, said):
    assert said in fault(spec(SCRIPT.format(text)))


def test_a_metric_of_hover_needs_half_a_second_before_the_edge(spec):
    text = SCRIPT.format("limits: {hover_thrust: {max: 30}}")
    load_spec(spec(text.replace("edge: 1", "edge: 0.5")))
    said = "hover_thrust needs an edge, half a second or more after the flight's begin"
    assert said in fault(spec(text.replace("edge: 1", "edge: 0.49")))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("load: force_w", "unknown load 'force_w': did you mean 'force_"),
        ("axis: x, load: force_x", "load and an axis are two steps"),
        ("load: force_x, acts: 9", "acts must be a time in seconds within the duration"),
        ("axis: x, acts: 1", "acts belongs to a load"),
        ("load: force_x, command: 1", "command belongs to a script"),
        ("load: force_x, limits: {rise_time: {max: 1}}", "rise_time needs a signal and a command"),
        ("load: force_x, limits: {mean_force: {max: 1}}", "mean_force needs an axis"),
    ],
)
def test_a_wrong_load_is_refused(spec, text, said):
    more = "" if "limits" in text else ", limits: {peak: {max: 1}}"
    found = fault(spec(f"cases:\n  - {{name: up, amplitude: 1, {text}{more}}}\n"))
    assert ":2: " in found
    assert said in found


def test_a_script_that_would_hover_for_years_is_refused(spec):
    text = SCRIPT.format("limits: {final: {max: 2}}").replace("edge: 1", "edge: 1e9")
    assert ":3: edge must be a time in seconds, 0 or later, and 600 s at most" in fault(spec(text))


def test_an_action_of_a_script_is_named_with_its_line(spec):
    text = SCRIPT.format("limits: {final: {max: 2}}").replace("[1, 0, 2]", "[1, 0]")
    assert ":5: script.0.go_to must be three finite numbers" in fault(spec(text))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("title: nothing\n", ":1: a spec has cases, or margins"),
        ("cases:\n  - {axis: z}\n", "name is ''"),
        ("cases:\n  - {name: ../up, axis: z}\n", ":2: name is '../up': use letters"),
        ("cases:\n  - {name: a, axis: w, amplitude: 1}\n", ":2: unknown axis 'w'"),
        ("cases:\n  - {name: a, axis: z}\n", "amplitude must be a finite number"),
        ("cases:\n  - {name: a}\n", ":2: 'a' has neither an axis nor a script"),
        (
            "margins: {rol: {gain_margin: {min: 2}}}\n",
            ":1: unknown loop 'rol': did you mean 'roll'",
        ),
        ("margins:\n  roll: {gain: {min: 2}}\n", ":2: unknown margin 'gain': known are bandwidth"),
        ("margins:\n  roll:\n    gain_margin: {}\n", ":3: gain_margin must have a min"),
        ("at: vq=1\nmargins: {roll: {gain_margin: {min: 2}}}\n", ":1: "),
        (
            "at: vx=5\nmargins:\n  position_x: {gain_margin: {min: 2}}\n",
            ":3: position_x is closed in hover only, and at is 'vx=5': leave one out",
        ),
        ("vehicle: {model: gone}\n", ":1: unknown model 'gone'"),
        ("world: nowhere\n", ":1: unknown world 'nowhere'"),
        ("estimator: kalman\ncases: []\n", ":1: unknown estimator 'kalman'"),
        ("rates: {physics_step: 1}\n", "must be at most"),
    ],
)
def test_a_wrong_spec_is_named_with_its_line(spec, text, said):
    assert said in fault(spec(text))


def test_two_cases_of_one_file_name_are_refused(spec):
    case = "axis: z, amplitude: 1, limits: {peak: {max: 2}}"
    text = f"cases:\n  - {{name: Up it, {case}}}\n  - {{name: up-it, {case}}}\n"
    assert ":3: there is 'up-it' already" in fault(spec(text))


def test_specs_are_found_by_name_file_and_folder(spec, tmp_path):
    path = spec("cases: []\n")
    (tmp_path / "other.yaml").write_text("")
    assert find_specs([str(tmp_path)]) == [path]
    assert find_specs([str(path), str(tmp_path)]) == [path]
    assert find_specs(["steps"]) == [find_spec("steps")]
    assert find_specs([]) == [find_spec(name) for name in list_specs()]
    (tmp_path / "empty").mkdir()
    with pytest.raises(WorkbenchError, match="has no file named"):
        find_specs([str(tmp_path / "empty")])
    with pytest.raises(WorkbenchError, match="unknown spec 'stesp': did you mean 'steps'"):
        find_specs(["stesp"])


@pytest.mark.parametrize("name", list_specs())
def test_a_shipped_spec_is_read_and_each_baseline_belongs_to_a_case(name):
    path = find_spec(name)
    spec = load_spec(path)
    names = [case.name for case in spec.content.cases]
    assert part_names(path)[: len(names)] == names
    kept = {case.name.lower().replace(" ", "-") for case in spec.content.cases if case.baseline}
    folder = specs_dir() / f"{name}.baseline"
    assert {file.stem for file in folder.glob("*.csv")} == kept | {"flown-with"}


def test_every_shipped_vehicle_has_a_spec():
    models = {load_spec(find_spec(name)).content.vehicle.model for name in list_specs()}
    assert models == set(list_models())


def test_a_trusted_folder_may_hold_the_controller_that_a_spec_names(spec, tmp_path):
    (tmp_path / "law.py").write_text((controllers_dir() / "pd.py").read_text())
    path = spec("controller: law.py\n" + STEP.format("limits: {peak: {max: 2}}"))
    assert "as --controller" in fault(path)
    assert load_spec(path, trusted=tmp_path).content.controller == str(tmp_path / "law.py")
    with pytest.raises(WorkbenchError, match="as --controller"):
        load_spec(path, trusted=tmp_path / "elsewhere")
