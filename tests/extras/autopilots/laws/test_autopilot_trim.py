"""Steady flights of the laws of autopilots."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import parse_point
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario


def test_derivatives_that_overflow_have_no_trim():
    """A limit of 1e-308 divides in the law; only its derivatives are not finite then."""
    study = LinearStudy(Scenario(controller="ardupilot"))
    with pytest.raises(WorkbenchError, match="no flight as 'hold=1' for dh_drone"):
        study.trim(parse_point("hold=1"), {"ATC_RATE_P_MAX": 1e-308, "ATC_RATE_R_MAX": 633.0})
