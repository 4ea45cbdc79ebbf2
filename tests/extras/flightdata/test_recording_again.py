"""What a recording of the workbench is flown again with, and what is compared."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.control.controller import LIMITS_GROUP
from workbench.control.controller_file import load_controller
from workbench.extras.flightdata import recording_again
from workbench.extras.flightdata.flying_again_question import FlyAgain
from workbench.scenario.scenario import Scenario


def flown_by(law, **more):
    flown = SimpleNamespace(
        name=law.name, reference=law.name, parameters=law.parameters, table=law.table
    )
    return SimpleNamespace(flown=flown, own={}, law=(), **more)


def test_another_law_has_its_own_gains_and_the_limits_of_the_recording():
    """A limit that was halved in flight holds for whoever flies; a gain of PD is none of PX4's."""
    pd, px4 = load_controller("pd"), load_controller("px4")
    limits = {
        row.name: 0.5 * (row.minimum + row.default)
        for row in px4.parameters
        if row.group == LIMITS_GROUP
    }
    record = SimpleNamespace(values={**limits, "kp_pitch": 140.0, "wind_x": 2.0})
    subject = flown_by(pd, other=lambda name: flown_by(px4))
    question = FlyAgain(Path("a.mcap"), {"kp_pitch": 90.0}, controller="px4")
    scenario, values, doubt = recording_again._with_other_gains(
        subject, question, record, Scenario(), pd
    )
    assert "max_speed" in limits and scenario.controller == "px4" and doubt == ""
    assert {name: values[name] for name in limits} == pytest.approx(limits)
    assert "kp_pitch" not in values


def test_after_a_loss_nothing_of_the_other_flight_is_shown(monkeypatch):
    """Lost at 0.75 s of 1 s, a constant 1 m beside the log until then."""
    time = np.arange(0.0, 1.001, 0.125)
    states = np.zeros((len(time), 13))
    record = SimpleNamespace(
        state_ns=(time * 1e9).astype(int), states=states, vehicle="drone", values={}
    )
    flown = SimpleNamespace(time=time, p_WB=np.ones((len(time), 3)), v_WB=np.zeros((len(time), 3)))
    law = load_controller("pd")
    for loss, seen in ((SimpleNamespace(time=0.75), time < 0.75), (None, time < 9.0)):
        monkeypatch.setattr(recording_again, "find_loss", lambda flown, loss=loss: loss)
        found = recording_again._compared(record, law, flown, "")
        assert np.isfinite(found.other).all(axis=1).tolist() == seen.tolist()
        np.testing.assert_allclose(found.difference, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        assert (found.stays, found.lost) == (loss is None, int(loss is not None))
