"""Margins of laws with slow parts are those of the periodic system that they make."""

import math

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.sampled_model import sampled_model
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario

LAWS = [law.name for law in map(load_controller, installed_laws()) if law.dividers]
CLIMB = 0.02
"""Climb diverges at 36 to 58 times the gain, at a sixth of the rate of the slow part, where its
aliases, which a model of the fast rate has not, make up this share."""
NEUTRAL = 1e-6
"""Of the eigenvalues of places and headings, which no loop holds."""


def each_update(study, trim):
    """Return the models of the updates of a whole period of the law, one after the other."""
    derivatives = study._derivatives
    whole = derivatives.update
    models = []
    for number in range(math.lcm(*study.controller.dividers)):
        derivatives.update = lambda *signals, number=number: derivatives._updated(
            derivatives._gains, float(number), *signals
        )
        models.append(
            sampled_model(derivatives, trim, study.scenario.rates, study._rate, study._delays)
        )
    derivatives.update = whole
    return models


def growth(models, point, gain):
    """Return the largest eigenvalue over the updates with the signal of a loop point scaled."""
    over = np.eye(len(models[0].A))
    for model in models:
        row = [signal.name for signal in model.outputs].index(point)
        column = [signal.name for signal in model.inputs].index(point)
        C, B = model.output_matrix[row], model.input_matrix[:, column]
        share = (gain - 1.0) / (1.0 - (gain - 1.0) * model.feedthrough[row, column])
        over = (model.A + share * np.outer(B, C)) @ over
    found = np.linalg.eigvals(over)
    return np.abs(found[np.abs(found - 1.0) > NEUTRAL]).max()


@pytest.mark.parametrize("name", ["pitch_rate", "pitch", "velocity_x", "velocity_z"])
@pytest.mark.parametrize("law", LAWS)
def test_the_gain_margin_is_that_of_the_periodic_system(law, name):
    study = LinearStudy(Scenario(controller=law))
    loop = study.controller.loop(name)
    point = OperatingPoint(hold=loop.hold)
    models = each_update(study, study.trim(point))
    margin = loop_margins(study.sampled(point), loop.point("actuator")).gain_margin
    close = CLIMB if name == "velocity_z" else 0.002
    assert growth(models, loop.point("actuator"), (1.0 - close) * margin) < 1.0
    assert growth(models, loop.point("actuator"), (1.0 + close) * margin) > 1.0
