"""Files of baselines: what is written is read again."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.series import Series
from workbench.design.regress.baseline import (
    changed_conditions,
    conditions,
    conditions_file,
    conditions_text,
    curves_file,
    curves_text,
    read_conditions,
    read_curves,
)
from workbench.design.regress.verdict import CurveComparison
from workbench.scenario.scenario import Scenario
from workbench.setup import make_setup

TIME = np.arange(5) / 128


def test_curves_come_back(tmp_path):
    flown = [
        CurveComparison(Series("v_x", "m/s", TIME, np.sin(TIME))),
        CurveComparison(Series("thrust", "N", TIME, 18.0 + TIME)),
    ]
    path = tmp_path / "x.csv"
    path.write_text(curves_text(flown))
    assert path.read_text().splitlines()[0] == "t [s],v_x [m/s],thrust [N]"
    found = read_curves(path)
    assert list(found) == ["v_x", "thrust"]
    assert (found["thrust"].name, found["thrust"].unit) == ("thrust", "N")
    assert found["v_x"].time == pytest.approx(TIME, rel=1e-6)
    assert found["thrust"].values == pytest.approx(18.0 + TIME, rel=1e-6)


def test_conditions_come_back(tmp_path):
    path = tmp_path / "flown-with.csv"
    values = {"kp_roll": 225.0, "rates physics_step": 1 / 1024, "tiny": -1.25e-17}
    path.write_text(conditions_text(values))
    assert read_conditions(path) == pytest.approx(values)


def test_each_number_of_an_inertia_is_a_condition():
    setup = make_setup(Scenario())
    before, I_B = conditions(setup), np.array(setup.vehicle.I_BBcm_B)
    for i, j in zip(*np.triu_indices(3), strict=True):
        other = I_B.copy()
        other[[i, j], [j, i]] += 1e-4
        vehicle = replace(setup.vehicle, I_BBcm_B=tuple(map(tuple, other.tolist())))
        changed = changed_conditions(before, conditions(replace(setup, vehicle=vehicle)))
        assert [each.name for each in changed] == [f"inertia_{'xyz'[i]}{'xyz'[j]}"]


def test_what_is_not_there_is_empty(tmp_path):
    assert read_curves(tmp_path / "none.csv") == {}
    assert read_conditions(tmp_path / "none.csv") == {}


@pytest.mark.parametrize(
    "text",
    ["", "t [s]\n", "a,b\n1,2\n2,3\n", "t [s],v_x [m/s]\n1,x\n", "t [s],v_x [m/s]\n1,2\n1,3\n",
     "t [s],v_x [m/s]\n1,2,3\n2,3,4\n", "t [s],v_x [m/s]\n1,2\n2,nan\n"],
)  # fmt: skip
def test_a_broken_table_is_named(tmp_path, text):
    path = tmp_path / "x.csv"
    path.write_text(text)
    with pytest.raises(WorkbenchError, match=r"x\.csv"):
        read_curves(path)


def test_broken_conditions_are_named(tmp_path):
    path = tmp_path / "flown-with.csv"
    path.write_text("name,value\nkp\n")
    with pytest.raises(WorkbenchError, match=r"flown-with\.csv: has no NAME,VALUE lines"):
        read_conditions(path)


def test_files_stand_beside_the_spec(tmp_path):
    spec = tmp_path / "gusty.workbench.yaml"
    assert curves_file(spec, "X up") == tmp_path / "gusty.baseline" / "x-up.csv"
    assert conditions_file(spec) == tmp_path / "gusty.baseline" / "flown-with.csv"
    assert curves_file(tmp_path / "odd.yaml", "a").parent.name == "odd.baseline"
