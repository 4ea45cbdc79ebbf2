"""`workbench pin`: what it refuses; docs/first-drone.md pins a step."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.design import pin
from workbench.design.pin import pin_step
from workbench.design.regress.flight import Changes
from workbench.design.regress.loading import load_spec
from workbench.design.regress.running import regress
from workbench.scenario.scenario import Scenario, SensorsConfig


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["mine.yaml"], "is not a name for a spec: name it NAME.workbench.yaml"),
        (["mine.workbench.yaml", "--amplitude", "0"], "the amplitude is 0"),
        (["mine.workbench.yaml", "--model", "nowhere"], "unknown model 'nowhere'"),
        (["mine.workbench.yaml", "--load", "gust_x", "--acts", "9"], "cannot act for 9 s in 5 s"),
        (["mine.workbench.yaml", "--load", "gust_x", "--axis", "x"], "not allowed with argument"),
    ],
)
def test_what_cannot_be_pinned_is_refused(refused, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused("pin", *words)
    assert not list(tmp_path.iterdir())


def test_a_spec_is_not_written_over(refused, tmp_path):
    spec = tmp_path / "mine.workbench.yaml"
    spec.write_text("mine")
    assert "exists already" in refused("pin", spec)
    assert spec.read_text() == "mine"


def test_a_pin_that_cannot_be_proved_leaves_files_as_they_were(tmp_path, monkeypatch):
    def refuse(path, controller):
        assert path.is_file()
        raise WorkbenchError("not repeatable")

    monkeypatch.setattr(pin, "_prove", refuse)
    (tmp_path / "turn.gains.yaml").write_text("gains: {}\n")
    step = {"duration": 1.0, "margins": False, "overwrite": True}
    with pytest.raises(WorkbenchError, match="not repeatable"):
        pin_step(tmp_path / "turn.workbench.yaml", Scenario(), {}, "yaw", 0.2, **step)
    assert [path.name for path in tmp_path.iterdir()] == ["turn.gains.yaml"]
    assert (tmp_path / "turn.gains.yaml").read_text() == "gains: {}\n"


@pytest.mark.slow
def test_a_flight_on_an_estimate_behind_a_filter_is_held_so(tmp_path):
    """Noise is that of the spec's seed: another flies beside the curves."""
    scenario = Scenario(estimator="ekf", sensors=SensorsConfig(seed=3))
    path = tmp_path / "mine.workbench.yaml"
    pinned = pin_step(path, scenario, {"gyro_lowpass": 60.0}, "y", 1.0, duration=1.0)
    assert pinned.loops == 9
    content = load_spec(path).content
    assert (content.estimator, content.sensors.seed) == ("ekf", 3)
    plain = pin_step(tmp_path / "plain.workbench.yaml", Scenario(), {}, "y", 1.0, duration=1.0)
    before = load_spec(plain.spec).content.margins["pitch"]["phase_margin_deg"]
    assert content.margins["pitch"]["phase_margin_deg"].min < before.min - 3.0
    assert all(each.passed for each in regress([path]))
    found = regress([path], Changes(seed=4))
    assert [each.passed for each in found] == [False, True]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("load", "gain"),
    [
        (["--load", "force_y", "--amplitude", "2", "--duration", "5"], "kp_velocity_y"),
        (["--load", "torque_roll", "--amplitude", "0.2", "--acts", "0.3"], "kp_roll"),
    ],
)
def test_a_load_is_pinned_and_a_weaker_gain_noticed(run, tmp_path, load, gain):
    """Half and twice the integrator's step stay within what is held; 0.7 of a gain does not."""
    path = tmp_path / "loaded.workbench.yaml"
    said = run("pin", path, *load, "--no-margins")
    assert said.code == 0
    assert f"4 numbers and 1 curves of a step {load[1]}" in said.out
    (case,) = load_spec(path).content.cases
    assert (case.load, case.axis, case.acts) == (load[1], "", 0.3 if "--acts" in load else None)
    (flown,) = regress([path])
    peak = next(each for each in flown.checks if each.name == "peak")
    assert case.limits["peak"].min < peak.value < case.limits["peak"].max
    for step in (1 / 2048, 1 / 512):
        assert all(each.passed for each in regress([path], Changes(physics_step=step)))
    weaker = {gain: 0.7 * {"kp_velocity_y": 4.45, "kp_roll": 225.0}[gain]}
    assert not any(each.passed for each in regress([path], Changes(settings=weaker)))
