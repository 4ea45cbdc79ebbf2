"""`workbench pin`: what it refuses; tests/docs/test_docs_first_drone.py pins a step."""

import pytest

from workbench.design.pin import pin_step
from workbench.design.regress.flight import Changes
from workbench.design.regress.loading import load_spec
from workbench.design.regress.running import regress
from workbench.scenario.scenario import Scenario, SensorsConfig


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["mine.yaml"], "is no name for a spec: name it NAME.spec.yaml"),
        (["mine.spec.yaml", "--amplitude", "0"], "the amplitude is 0"),
        (["mine.spec.yaml", "--model", "nowhere"], "unknown model 'nowhere'"),
    ],
)
def test_what_cannot_be_pinned_is_refused(refused, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused("pin", *words)
    assert not list(tmp_path.iterdir())


def test_a_spec_is_not_written_over(refused, tmp_path):
    spec = tmp_path / "mine.spec.yaml"
    spec.write_text("mine")
    assert "is there already" in refused("pin", spec)
    assert spec.read_text() == "mine"


def test_a_flight_on_an_estimate_behind_a_filter_is_held_so(tmp_path):
    """Noise is that of the spec's seed: another flies beside the curves."""
    scenario = Scenario(estimator="ekf", sensors=SensorsConfig(seed=3))
    path = tmp_path / "mine.spec.yaml"
    pinned = pin_step(path, scenario, {"gyro_lowpass": 60.0}, "y", 1.0, duration=1.0)
    assert pinned.loops == 9
    content = load_spec(path).content
    assert (content.estimator, content.sensors.seed) == ("ekf", 3)
    plain = pin_step(tmp_path / "plain.spec.yaml", Scenario(), {}, "y", 1.0, duration=1.0)
    before = load_spec(plain.spec).content.margins["pitch"]["phase_margin"]
    assert content.margins["pitch"]["phase_margin"].min < before.min - 0.05
    assert all(each.passed for each in regress([path]))
    found = regress([path], Changes(seed=4))
    assert [each.passed for each in found] == [False, True]
