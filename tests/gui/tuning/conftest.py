"""A flight that only takes orders down, and an analyst who only listens."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.analysis.judging import draw_frequency
from workbench.analysis.judging import judge_gains as judge_loops
from workbench.analysis.loop_placing import move_pole, sample_reach, shape_loop
from workbench.analysis.queries import (
    DrawFrequency,
    Judge,
    MovePole,
    Predict,
    SampleReach,
    ShapeLoop,
)
from workbench.analysis.replies import Judged, JudgedLoop, Predicted
from workbench.analysis.subject import AnalysedVehicle
from workbench.design.step_metrics import StepMetrics
from workbench.gui.analysis import Analysis, query_key
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.scenario.scenario import Action, Scenario

LOOPS = ("velocity_x", "velocity_y", "velocity_z", "roll", "pitch", "yaw_rate")


class Listener(Analysis):
    """Takes questions down.

    Attributes:
        asked: all of them.
    """

    def __init__(self, notices) -> None:
        super().__init__(notices)
        self.asked = []
        self.stopped = 0

    def ask(self, question) -> None:
        self.asked.append(question)

    def stop(self) -> None:
        self.stopped += 1

    def of(self, kind) -> list:
        """Return the questions of a kind."""
        return [question for question in self.asked if isinstance(question, kind)]


class Grounded(FlightModel):
    """A flight that obeys at once, and flies nothing.

    Attributes:
        orders: that were given.
    """

    def __init__(self, notices) -> None:
        super().__init__(notices)
        self.orders = []

    @property
    def is_flying(self) -> bool:
        return True

    def do(self, order, done=None, refused=None) -> None:
        self.orders.append(order)
        if done is not None:
            done(1.0 if isinstance(order, Action) else f"answer to {order.name}")

    def show(self, view) -> None:
        """Let this be the newest view."""
        self._view = view


@pytest.fixture
def offline(workspace):
    """A workspace whose flight takes orders down and whose analyst listens."""
    made = dataclasses.replace(
        workspace, flight=Grounded(workspace.notices), analysis=Listener(workspace.notices)
    )
    yield made
    made.flight.close()
    made.analysis.close()


@pytest.fixture
def flying(canned):
    """The view of a drone that flies."""
    return canned.views[-1]


@pytest.fixture
def gains(offline, flying):
    """Gains of the drone that flies."""
    offline.preferences.set("apply_gains", "on Enter")
    made = GainEditor(offline.flight, offline.analysis, offline.preferences, offline.notices)
    offline.flight.show(flying)
    made.begin(flying)
    return made


@pytest.fixture
def trial(gains):
    """What is tried with them."""
    return TuningTrial(gains)


def loop(name: str, **other) -> JudgedLoop:
    """Return a comfortable loop, with what is otherwise."""
    values = {
        "gain_margin": 4.0,
        "gain_reduction_margin": 0.0,
        "phase_margin": np.radians(60.0),
        "delay_margin": 0.05,
        "disk_margin": 1.0,
        "peak_sensitivity": 1.5,
        "bandwidth": np.nan,
        "crossover": 10.0,
        "stable": True,
        "growing": False,
    }
    return JudgedLoop(name=name, **{**values, **other})


@pytest.fixture
def judge():
    """Returns a question about gains, and a judgement with other loops where wanted."""

    def make(gains, *others: JudgedLoop, poles=(-1.0, -2.0 + 3.0j, -2.0 - 3.0j), said=""):
        named = {each.name: each for each in others}
        loops = tuple(named.get(name, loop(name)) for name in LOOPS)
        stable = all(each.stable for each in loops)
        asked = Judge(controller_gains(gains))
        return asked, Judged(loops, np.array(poles, dtype=complex), stable, said)

    return make


@pytest.fixture
def make_loop():
    """Returns a loop."""
    return loop


@pytest.fixture
def predict():
    """Returns a question about a step, and a first-order prediction."""

    def make(gains, step, lost=False):
        time = np.arange(0.0, step.duration, 1 / 128)
        numbers = StepMetrics(0.3, 0.6, 12.0, steady_state_error=0.5, peak_rotor_use=0.8)
        response = step.amplitude * (1.0 - np.exp(-5.0 * time))
        asked = Predict(controller_gains(gains), step)
        return asked, Predicted(time, response, numbers, lost)

    return make


@pytest.fixture
def screen(offline, flying, qtbot):
    """The tuning screen; a proposed value does not fly by itself."""
    offline.preferences.set("apply_gains", "on Enter")
    offline.flight.show(flying)
    made = TuningScreen(offline)
    qtbot.addWidget(made)
    made.resize(1500, 900)
    made.begin(flying)
    made.show()
    yield made
    made.close_screen()


@pytest.fixture(scope="session")
def subject():
    """What an analyst knows of the shipped drone; its models are made once for all tests."""
    return AnalysedVehicle(Scenario(), {})


@pytest.fixture
def answered_kinds():
    """Functions that answer, by the kind of question."""
    return {
        Judge: judge_loops,
        DrawFrequency: draw_frequency,
        ShapeLoop: shape_loop,
        MovePole: move_pole,
    }


@pytest.fixture
def with_reach(answered_kinds):
    """Let the reach of a loop's sliders be answered, too, which takes a second each time."""
    answered_kinds[SampleReach] = sample_reach


@pytest.fixture(scope="session")
def reply_to(subject):
    """Return what answers a question by a function: one that tests asked before, as then."""
    replies, goes_on = {}, SimpleNamespace(check=lambda: None)

    def reply(function, question):
        key = function, query_key(question)
        if key not in replies:
            replies[key] = next(each for each in function(subject, question, goes_on) if each)
        return replies[key]

    return reply


@pytest.fixture
def settle(offline, qtbot, reply_to, answered_kinds):
    """Returns what answers as the analyst's process would, until something is so."""
    done = [0]

    def answer():
        waiting = offline.analysis.asked[done[0] :]
        done[0] = len(offline.analysis.asked)
        for question in waiting:
            if type(question) in answered_kinds:
                reply = reply_to(answered_kinds[type(question)], question)
                offline.analysis.tell(question, reply)
        return bool(waiting)

    def until(so):
        qtbot.waitUntil(lambda: not answer() and bool(so()), timeout=60_000)

    return until
