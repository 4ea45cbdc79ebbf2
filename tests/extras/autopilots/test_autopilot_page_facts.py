"""Facts on the pages of autopilots."""

from pathlib import Path

from workbench.extras.autopilots.gain_files.table import load_table

ROOT = Path(__file__).parents[3]


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def test_the_factors_between_versions_of_autopilots_are_those_of_the_table():
    rows = [each for name in ("ardupilot", "px4") for each in load_table(name).settings]
    factors = {(each.name, each.law): each.scale for each in rows}
    assert factors["PSC_ACCZ_P", "PSC_D_ACC_P"] == 0.1
    assert factors["PSC_ACCZ_IMAX", "PSC_D_ACC_IMAX"] == 0.001
    assert factors["PSC_VELZ_IMAX", "PSC_D_VEL_IMAX"] == 0.01
    assert factors["PSC_ACCZ_FF", "PSC_D_ACC_FF"] == 1.0
    assert factors["MPC_XY_VEL_P", "MPC_XY_VEL_P_ACC"] == 20.0
    text = " ".join(page("autopilot-gains.md").split())
    assert "a `PSC_ACCZ_P` of 0.5 becomes a `PSC_D_ACC_P` of 0.05" in text
    assert "a `MPC_XY_VEL_P` of 0.1 a `MPC_XY_VEL_P_ACC` of 2" in text
