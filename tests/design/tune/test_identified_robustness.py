"""How unsure a vehicle is by what was identified of it."""

import pytest

from workbench.commands.cli import main
from workbench.design.tune.case import Robustness, identified_robustness, robustness_corners

SIDECAR = """identified:
- {name: lag_with_delay, unit: s, value: 0.06, low: 0.057, high: 0.066}
- {name: thrust_to_weight, unit: '1', value: 2.0, low: 1.96, high: 2.02}
- {name: inertia_x, unit: kg m^2, value: 2.0e-5, low: 1.9e-5, high: 2.1e-5}
- {name: inertia_z, unit: kg m^2, value: 4.0e-5, low: 3.0e-5, high: 4.4e-5}
"""


@pytest.fixture
def sidecar(tmp_path):
    path = tmp_path / "flown.rotors.yaml"
    path.write_text(SIDECAR)
    return path


def test_shares_are_those_of_the_intervals(sidecar):
    """By hand: 0.006 / 0.06, 0.04 / 2 and 1 / 4, the farther end of each."""
    found = identified_robustness(sidecar)
    assert found == Robustness(
        mass=pytest.approx(0.02), inertia=pytest.approx(0.25), rotor_lag=pytest.approx(0.1)
    )
    assert sorted({case.rotor_lag for case in robustness_corners(found)}) == pytest.approx(
        [0.9, 1.1]
    )


def test_what_was_not_identified_keeps_its_default(sidecar):
    sidecar.write_text("\n".join(SIDECAR.splitlines()[:2]))
    assert identified_robustness(sidecar) == Robustness(rotor_lag=pytest.approx(0.1))
    sidecar.write_text("rotors: []\n")
    assert identified_robustness(sidecar) is None


def test_the_command_says_what_it_takes(sidecar, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sidecar.write_text(SIDECAR.replace("value: 0.06", "value: nothing"))
    assert main(["tune", "--rotors", str(sidecar), "--evaluations", "1"]) == 2
    assert "flown.rotors.yaml:2" in capsys.readouterr().err
