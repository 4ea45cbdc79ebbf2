"""The app is tested as in the tests of the core's screens."""

import numpy as np
import pytest

from tests.gui.conftest import (
    canned,
    hasty,
    no_thread_is_left,
    nothing_is_held,
    qtbot,
    shared_window,
    shared_workspace,
    workspace,
)
from tests.gui.tuning.conftest import flying, gains, offline, trial
from tests.gui.visualization.conftest import begun
from workbench.extras.flightdata.flying_again_question import FlownAgain, FlyAgain

__all__ = [
    "begun",
    "canned",
    "flying",
    "gains",
    "hasty",
    "no_thread_is_left",
    "nothing_is_held",
    "offline",
    "qtbot",
    "shared_window",
    "shared_workspace",
    "trial",
    "workspace",
]


@pytest.fixture(scope="session")
def fly_again():
    """Returns a question about a logged flight, and an answer: 0.1 m to the side of it."""

    def make(question: FlyAgain, **other) -> tuple[FlyAgain, FlownAgain]:
        time = np.linspace(4.0, 24.0, 400)
        logged = np.column_stack([np.sin(time + phase) for phase in range(6)])
        values = {
            "vehicle": "dh_drone",
            "logged_vehicle": "dh_drone",
            "doubt": "",
            "flown": "pd",
            "flown_gains": {name: question.gains[name] for name in ("kp_pitch", "kp_velocity_x")},
            "setpoint": logged[:, :3],
            "other": logged + 0.1,
            "low": logged + 0.08,
            "high": logged + 0.12,
            "off_setpoint": np.array([[0.0] * 3, [0.1] * 3]),
            "difference": np.full(6, 0.1),
            "band": np.full(6, 0.02),
            "stays": True,
            "lost": 0,
            "drawn": 1 + question.draws,
        }
        return question, FlownAgain(time=time, logged=logged, **{**values, **other})

    return make
