"""The operating map, against models made one by one, and its table."""

import csv
import math

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.operating_map import MAP_DIRECTIONS, find_direction, operating_map
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig


@pytest.fixture(scope="module")
def found():
    return operating_map("speed", "payload", first_values=[0.0, 6.0], second_values=[1.0, 1.2])


def test_a_point_of_the_map_is_the_model_there(found):
    scenario = Scenario(vehicle=VehicleConfig(variation=Variation(mass=1.2)))
    model = LinearStudy(scenario).sampled(OperatingPoint(velocity=(6.0, 0.0, 0.0)))
    margins = [m for loop in judge_loops(model) for m in (loop.actuator, loop.error)]
    assert found.phase_margin[1, 1] == pytest.approx(min(m.phase_margin for m in margins))
    assert found.disk_margin[1, 1] == pytest.approx(min(m.disk_margin for m in margins))
    assert found.weakest[1][1] in ("roll", "pitch")


def test_more_payload_and_speed_change_the_margins(found):
    assert found.phase_margin.shape == found.damping.shape == (2, 2)
    assert len({round(float(x), 6) for x in found.disk_margin.ravel()}) == 4
    assert (found.damping > 0.2).all()


def test_the_table_has_a_row_a_point(found, tmp_path):
    found.write_csv(tmp_path / "map.csv")
    rows = list(csv.reader((tmp_path / "map.csv").read_text().splitlines()))
    assert rows[0][:3] == ["speed [m/s]", "payload [1]", "phase_margin_deg [deg]"]
    assert [float(x) for x in rows[2][:2]] == [6.0, 1.0]
    assert float(rows[2][3]) == pytest.approx(found.disk_margin[0, 1])


def test_what_cannot_be_flown_is_a_hole():
    found = operating_map("climb", "tilt", first_values=[0.0], second_values=[0.1, 1.3])
    assert math.isfinite(found.damping[0, 0])
    assert np.isnan(found.damping[1, 0])
    assert found.weakest[1][0] == ""


def test_the_usual_ranges_can_be_flown(study):
    for direction in MAP_DIRECTIONS:
        assert direction.low < direction.high
        assert find_direction(direction.name) is direction


@pytest.mark.parametrize(
    ("first", "second", "values", "word"),
    [
        ("sped", "tilt", None, "did you mean 'speed'"),
        ("speed", "speed", None, "two directions"),
        ("speed", "tilt", [], "no values"),
        ("speed", "tilt", [math.nan], "no values"),
    ],
)
def test_bad_directions_are_refused(first, second, values, word):
    with pytest.raises(WorkbenchError, match=word):
        operating_map(first, second, first_values=values)
