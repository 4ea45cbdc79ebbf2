"""A flight and an analyst that answer when a test says so."""

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import pytest
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import FindRanges
from workbench.analysis.replies import Judged
from workbench.control.controller_file import load_controller
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_files import GainFiles
from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS_SIGNAL, drone_topics
from workbench.link.signal import TopicOptions
from workbench.live.view import LiveView

TOPICS = drone_topics(TopicOptions(rotors=4, fast=128.0, slow=16.0))
PARAMETERS_TOPIC = next(topic for topic in TOPICS if topic.id == PARAMETERS_SIGNAL.id)


@dataclass
class Ordered:
    """An order that the fake flight was given."""

    values: dict[str, float]
    done: object
    refused: object


class FakeFlight(QObject):
    """Takes orders as `FlightModel` does; a test answers them, or they answer at once."""

    streamed = pyqtSignal(object)
    viewed = pyqtSignal(object)

    def __init__(self, notices) -> None:
        super().__init__()
        self._notices = notices
        self.at_once = True
        self.given: list[tuple[str, float]] = []
        self.waiting: list[Ordered] = []
        self.time = 1.0

    def do(self, order, done=None, refused=None) -> None:
        self.given += order.set.items()
        self.waiting.append(Ordered(order.set, done, refused))
        if self.at_once:
            self.answer()

    def answer(self) -> None:
        """Obey the oldest order."""
        self.time += 0.01
        self.waiting.pop(0).done(self.time)

    def refuse(self, said: str) -> None:
        """Refuse the oldest order."""
        self.waiting.pop(0).refused(said)

    def publish(self, time: float, **values: float) -> None:
        """Tell of parameters that have changed."""
        self.streamed.emit(
            [
                Published(
                    round(time * 1e9),
                    0,
                    ((PARAMETERS_SIGNAL.id, PARAMETERS_TOPIC.pack((name, value))),),
                )
                for name, value in values.items()
            ]
        )


class FakeAnalysis(QObject):
    """Hears questions; a test answers them."""

    answered = pyqtSignal(object, object)
    refused = pyqtSignal(object, str)
    preparing = pyqtSignal(str)

    def __init__(self) -> None:
        super().__init__()
        self.asked: list = []
        self.tell = self.answered.emit

    def ask(self, question) -> None:
        self.asked.append(question)

    def known(self, question) -> None:
        """Return no answer: each question is asked."""

    def judge(self, stable: bool, said: str = "a swing would grow") -> None:
        """Answer the last question."""
        self.tell(self.asked[-1], Judged((), None, stable, "" if stable else said))


@dataclass
class Rig:
    """Gains between a fake flight and a fake analyst."""

    editor: GainEditor
    gain_files: GainFiles
    flight: FakeFlight
    analysis: FakeAnalysis
    view: LiveView
    told: list = field(default_factory=list)

    def know(self, **stable: tuple[float, float]) -> None:
        """Find ranges around what flies: those, and the limits of every other gain."""
        every = {
            row.name: (row.minimum, row.maximum)
            for row in load_controller().table
            if row.system == "controller"
        }
        gains = {name: self.editor.flown[name] for name in every}
        self.analysis.tell(FindRanges(gains), every | stable)


def start_values() -> dict[str, float]:
    """Return a value for every row, as the table has it."""
    return {row.name: row.default for row in load_controller().table}


@pytest.fixture
def new_view(tmp_path):
    """Makes the first view of a flight of a new vehicle."""

    def make(**values: float) -> LiveView:
        vehicle = SimpleNamespace(name="dh_drone", source=tmp_path / "drone.urdf")
        return LiveView(values=start_values() | values, vehicle=vehicle, topics=TOPICS)

    return make


@pytest.fixture
def rig(workspace, new_view):
    """Gains of a flight that has begun; every gain is 3, 150, ... as the table has it."""
    flight, analysis = FakeFlight(workspace.notices), FakeAnalysis()
    editor = GainEditor(flight, analysis, workspace.preferences, workspace.notices)
    gain_files = GainFiles(editor, workspace.notices)
    made = Rig(editor, gain_files, flight, analysis, new_view())
    workspace.notices.told.connect(made.told.append)
    editor.begin(made.view)
    yield made
    gain_files.close()


@pytest.fixture
def gain_file(tmp_path) -> Path:
    """A gain file that differs from the table in two lines."""
    path = tmp_path / "brisk.yaml"
    path.write_text(
        "vehicle: dh_drone\norigin: found by hand\n"
        "gains:\n  kp_velocity_x: 4.5 1/s\n  kp_roll: 200.0 1/s^2\n  kd_roll: 20.0 1/s\n"
    )
    return path
