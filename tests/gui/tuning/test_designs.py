"""Since when a set of gains flies, and what flew at a time."""

from types import SimpleNamespace

import pytest
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.tuning.designs import Designs
from workbench.gui.units import simulated_text

SOFT, HARD, NEVER = ({"kp_roll": value} for value in (100.0, 200.0, 300.0))


class Gains(QObject):
    """Stored gains."""

    state_changed = pyqtSignal()
    kept, proposed, slots = NEVER, NEVER, {"A": SOFT, "B": HARD}

    def of_set(self, values):
        return values


class Trial(QObject):
    """A flight whose gains and law a test changes."""

    changed = pyqtSignal()

    def __init__(self):
        super().__init__()
        self.gains, self.proposed = Gains(self), NEVER
        self.flight = SimpleNamespace()
        self.flown = {}

    def fly(self, time, gains, controller="pd"):
        scenario, snapshot = SimpleNamespace(controller=controller), SimpleNamespace(time=time)
        self.flight.view = SimpleNamespace(scenario=scenario, snapshot=snapshot)
        self.flown = gains
        self.changed.emit()


@pytest.fixture
def trial(qapp):
    made = Trial()
    made.fly(0.0, {})
    return made


@pytest.fixture
def designs(trial):
    return Designs(trial.flight, trial, trial)


def test_a_set_says_when_it_flew_last(trial, designs):
    for time, gains in ((1.0, SOFT), (2.0, HARD), (3.0, SOFT), (4.0, HARD), (5.0, SOFT)):
        trial.fly(time, gains)
    said = {each.name: each.long[-1] for each in designs.all() if not each.controller}
    first, last = simulated_text(4.0), simulated_text(5.0)
    assert said["flown"] == said["A"] == f"flies since {last}"
    assert said["B"] == f"flew from {first} to {last}"
    assert said["kept"] == said["proposed"] == "has not flown"


def test_what_flew_at_a_time_flew_from_its_first_instant_on(trial, designs):
    trial.fly(1.0, SOFT, "lqi")
    trial.fly(2.0, SOFT, "pd")
    assert designs.flight_name(1.99, SOFT) == f"lqi at {simulated_text(1.99)}"
    assert designs.flight_name(2.0, SOFT) == f"A at {simulated_text(2.0)}"
