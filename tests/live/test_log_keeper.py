"""Logs that begin and end while a flight goes on."""

import sys
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import controllers_dir
from workbench.live.log_keeper import ActionHistory, LogKeeper
from workbench.logs.record import read_log
from workbench.scenario.scenario import Action, Gust, Push, Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


class Flight:
    """A session and its log keeper."""

    def __init__(self) -> None:
        self.session = Session(Scenario(), bridge=Bridge())
        self.keeper = LogKeeper(self.session, {}, self.session.parameters())

    def take_over(self, law: Path) -> None:
        action = Action(self.session.time, controller=str(law))
        self.session.do(action)
        self.keeper.act(action, "operator")

    def fly(self, seconds: float) -> None:
        self.session.tick(seconds)
        for sampled in self.session.drain():
            self.keeper.write(sampled)


@pytest.fixture
def flight() -> Flight:
    return Flight()


@pytest.fixture
def write_law(tmp_path):
    """Write the shipped law under another name, which is in its text."""

    def write(name: str) -> Path:
        path = tmp_path / f"{name}.py"
        text = (controllers_dir() / "pd.py").read_text(encoding="utf-8")
        path.write_text(f"# {name}\n{text}", encoding="utf-8")
        return path

    return write


def test_what_was_done_before_the_log_is_in_it(flight, tmp_path):
    flight.keeper.act(Action(0.25, velocity=[1.0, 0.0, 0.0]), "one")
    flight.fly(0.5)
    path = flight.keeper.start(str(tmp_path / "flight.mcap"))
    flight.keeper.act(Action(0.5, set={"kp_roll": 90.0}), "operator")
    flight.fly(0.5)
    assert flight.keeper.path == path
    assert flight.keeper.stop() == path
    assert flight.keeper.path == flight.keeper.stop() == ""
    record = read_log(Path(path))
    assert [(each.action.at, each.by) for each in record.done] == [(0.25, "one"), (0.5, "operator")]


def test_only_one_is_written_at_a_time(flight, tmp_path):
    flight.keeper.start(str(tmp_path / "one.mcap"))
    with pytest.raises(WorkbenchError, match="one.mcap is being written"):
        flight.keeper.start(str(tmp_path / "two.mcap"))
    flight.keeper.stop()
    flight.keeper.start(str(tmp_path / "two.mcap"))
    flight.keeper.stop()


def test_a_flight_that_begins_anew_has_the_next_file(flight, tmp_path):
    flight.keeper.start(str(tmp_path / "flight.mcap"))
    flight.keeper.act(Action(0.0, yaw_rate=0.1), "one")
    flight.fly(0.5)
    for number in (2, 3):
        flight.session.reset()
        flight.keeper.begin_anew()
        flight.fly(0.5)
        assert flight.keeper.path == str(tmp_path / f"flight-{number}.mcap")
    flight.keeper.stop()
    assert len(read_log(tmp_path / "flight.mcap").done) == 1
    assert read_log(tmp_path / "flight-3.mcap").done == ()
    flight.keeper.start(str(tmp_path / "flight.mcap"))
    flight.session.reset()
    flight.keeper.begin_anew()
    assert flight.keeper.stop() == str(tmp_path / "flight-4.mcap")  # 2 and 3 stay
    assert len(flight.keeper.done) == 0


def test_a_log_of_a_later_flight_has_the_laws_of_that_flight(flight, tmp_path, write_law):
    """A law took over in the first flight, another one in the second, before its log begins."""
    flight.take_over(write_law("first"))
    flight.session.reset()
    flight.keeper.begin_anew()
    flight.take_over(write_law("second"))
    path = flight.keeper.start(str(tmp_path / "flight.mcap"))
    flight.fly(0.1)
    flight.keeper.stop()
    record = read_log(Path(path))
    (text,) = record.laws.values()
    assert "first" in record.law and "second" in text


def test_a_log_of_a_later_flight_has_the_values_of_its_own_law(flight, tmp_path):
    """With those of another one it could not be flown again."""
    flight.take_over(Path("pid"))
    flight.session.reset()
    flight.keeper.begin_anew()
    values = flight.session.parameters()
    path = flight.keeper.start(str(tmp_path / "flight.mcap"))
    flight.fly(0.1)
    flight.keeper.stop()
    assert "ki_rate" in values and read_log(Path(path)).values == values


def test_a_log_that_cannot_go_on_says_so_and_the_flight_does(flight, tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    flight.keeper.start(str(folder / "flight.mcap"))
    folder.rename(tmp_path / "gone")
    flight.session.reset()
    flight.keeper.begin_anew()
    assert "moved or deleted" in flight.keeper.said
    flight.fly(0.1)
    assert flight.keeper.path == ""


ACTIONS = [
    Action(0.0, velocity=[1.0, -2.0, 0.1], yaw_rate=0.3),
    Action(0.25, velocity=[1.0, 0.0, 0.0]),
    Action(0.25, yaw_rate=0.1),
    Action(0.5, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0, request="land"),
    Action(0.75, request="take_off", height=2.0),
    Action(1.0, go_to=[1.0, 2.0, 3.0]),
    Action(1.25, set={"kp_roll": 90.0}),
    Action(1.5, gust=Gust([1.0, 0.0, 0.0], 2.0), push=Push([0.0, 1.0, 0.0])),
    Action(0.1 + 0.2, velocity=[5e-324, 1e300, -0.0], yaw_rate=1 / 3),
]


@pytest.fixture
def history() -> ActionHistory:
    history = ActionHistory()
    for index, action in enumerate(ACTIONS):
        history.append(action, ("one", "operator", "link")[index % 3])
    return history


def test_all_come_back_to_the_bit_and_in_their_order(history):
    assert len(history) == len(ACTIONS)
    assert list(map(repr, history.actions)) == list(map(repr, ACTIONS))
    assert [by for _, by in history] == ["one", "operator", "link"] * 3


def test_nothing_is_left_once_it_is_cleared(history):
    history.clear()
    assert list(history) == []
    others = ACTIONS[5:] + ACTIONS[:5]  # a command where another kind was before
    for action in others:
        history.append(action, "two")
    assert list(history) == [(action, "two") for action in others]


def test_an_hour_of_steering_takes_a_few_megabytes():
    history = ActionHistory()
    for index in range(20 * 3600):
        history.append(Action(index / 20, velocity=[1.0, 0.0, 0.0], yaw_rate=0.1), "one")
    assert sys.getsizeof(history._numbers) + sys.getsizeof(history._who) < 5_000_000
    assert not history._others
