import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import OperatingPoint, parse_point


@pytest.mark.parametrize(
    ("text", "point"),
    [
        ("hover", OperatingPoint()),
        ("vx=5, vz=-1", OperatingPoint(velocity=(5.0, 0.0, -1.0))),
        ("yaw_rate=0.2,ay=3", OperatingPoint(yaw_rate=0.2, acceleration=(0.0, 3.0, 0.0))),
        ("hold=1", OperatingPoint(hold=True)),
    ],
)
def test_a_text_names_a_point_and_back(text, point):
    assert parse_point(text) == point
    assert parse_point(point.label) == point


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed=3", "unknown quantity of an operating point 'speed'"),
        ("vx=fast", "'vx=fast' is not part of an operating point"),
        ("vx", "'vx' is not part"),
        ("vz=1,vx=nan", "'vx=nan' is not the value of a steady flight: give a finite number"),
        ("yaw_rate=inf", "'yaw_rate=inf' is not the value of a steady flight"),
        ("vx=1,vz=2,vx=3", "has vx twice: give it once"),
        ("hover,hover", "has hover twice"),
        ("hover,vx=3", "'hover,vx=3' is hover and more"),
        ("hold=1,hover", "is hover and more"),
        ("vx=1,hold=1", "the position is held in hover only"),
        ("", "unknown quantity"),
    ],
)
def test_what_is_no_point_is_said(text, said):
    with pytest.raises(WorkbenchError, match=said.replace("(", r"\(")):
        parse_point(text)


def test_each_name_is_the_axis_that_it_says(case):
    for place, axis in enumerate("xyz"):
        three = tuple(2.5 * (each == place) for each in range(3))
        with case(axis):
            assert parse_point(f"v{axis}=2.5") == OperatingPoint(velocity=three)
            assert parse_point(f"a{axis}=2.5") == OperatingPoint(acceleration=three)
    assert parse_point("hold=0") == OperatingPoint()
