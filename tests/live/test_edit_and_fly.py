"""A law's file is saved while the law flies: the text takes over, or a sentence says why not."""

import os
import time
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.live.flight import LiveFlight
from workbench.live.flying import FlightLoop
from workbench.live.messages import ControllerChange, FlightNotice, Phase
from workbench.live.orders import FlightOrder
from workbench.logs.record import read_log
from workbench.logs.replay import replay
from workbench.scenario.scenario import Action, Scenario
from workbench.scenario.scenario_file import load_scenario, save_scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

TEXT = (Path(__file__).parents[1] / "controllers/cascade.py").read_text(encoding="utf-8")
ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""


class KeptMessages:
    """A send queue that keeps all."""

    def __init__(self) -> None:
        self.sent: list[object] = []

    def post(self, message: object) -> None:
        self.sent.append(message)

    show = post


class Bench:
    """A `FlightLoop` that watches its law's file, and its wall clock."""

    def __init__(self, scenario: Scenario) -> None:
        self.wall, self.messages, bridge = 0.0, KeptMessages(), Bridge()
        self.session = Session(scenario, bridge=bridge)
        self.flying = FlightLoop(
            self.session, bridge, {}, self.messages, lambda: self.wall, watch=True
        )

    def fly(self, seconds: float) -> None:
        end = self.wall + seconds
        while self.wall < end:
            self.wall += 1 / 128
            self.flying._watch()
            self.flying.fly()

    def said(self) -> list[str]:
        return [message.said for message in self.messages.sent if isinstance(message, FlightNotice)]


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(TEXT, encoding="utf-8")
    return path


def in_place(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
    later = path.stat().st_mtime_ns + 1_000_000_000  # a file system may count in whole seconds
    os.utime(path, ns=(later, later))


def renamed(path: Path, text: str) -> None:
    new = path.with_suffix(".new")
    new.write_text(text, encoding="utf-8")
    new.replace(path)


def wait_for(condition) -> None:
    end = time.monotonic() + ENOUGH
    while not condition():
        assert time.monotonic() < end, "it does not come about"
        time.sleep(0.01)


def remarks_with(words: str, flight: LiveFlight) -> list[str]:
    return [remark for remark in flight.latest().remarks if words in remark]


def test_an_edited_law_flies_at_once_and_stays_after_a_reset(mine):
    bench = Bench(Scenario(controller=str(mine)))
    first = bench.session.controller
    bench.fly(0.5)
    in_place(mine, TEXT + "# edited\n")
    bench.fly(0.5)
    second = bench.session.controller
    assert second is not first and second.text.endswith("# edited\n")
    assert bench.said()[-1].startswith("mine has taken over at ")
    assert bench.session.time == 1.0 - 1 / 128  # the clock restarts, and a slice is not caught up
    bench.flying.do(_order(FlightOrder.RESET))
    assert bench.session.controller is second


def test_a_reset_of_a_script_that_let_a_law_take_over_tells_of_the_first_law(mine):
    script = [Action(at=0.25, controller="lqi")]
    bench = Bench(Scenario(controller=str(mine), script=script))
    bench.fly(0.5)
    in_place(mine, TEXT + "# of another law than the one that flies\n")
    bench.fly(0.5)
    bench.flying.do(_order(FlightOrder.RESET))
    bench.fly(0.1)
    told = [each for each in bench.messages.sent if isinstance(each, ControllerChange)]
    assert [each.controller.name for each in told[:2]] == ["lqi", "mine"]
    assert told[0].named == "lqi" and told[1].named == str(mine)
    assert "k_tilt" in told[1].values and "k_tilt" not in told[0].values


def test_a_law_without_what_the_script_sets_is_refused_before_it_breaks_the_flight(mine):
    script = [Action(at=0.5, set={"k_tilt": 99.0})]
    bench = Bench(Scenario(controller=str(mine), script=script))
    bench.fly(0.25)
    in_place(mine, TEXT.replace("k_tilt", "k_lean"))
    bench.fly(1.0)
    assert bench.said()[-1].startswith("unknown parameter 'k_tilt'")
    assert bench.said()[-1].endswith("mine flies on as it was")
    assert bench.session.get("k_tilt") == 99.0 and not bench.flying._broken


def test_in_a_pause_a_law_takes_over_and_time_stands_and_a_broken_flight_waits_for_its_reset(mine):
    bench = Bench(Scenario(controller=str(mine)))
    bench.fly(0.25)
    bench.flying.do(_order(FlightOrder.PAUSE))
    renamed(mine, TEXT.replace('2.5, "acceleration per', '3.5, "acceleration per'))
    bench.fly(0.5)
    assert bench.session.time == 0.25 and bench.session.controller.text != TEXT
    assert bench.session.get("k_speed") == 2.5  # which flies goes on with its value
    bench.flying.do(_order(FlightOrder.RESUME))
    text = bench.session.controller.text
    bench.session.tick = _broken
    bench.fly(0.1)
    in_place(mine, TEXT)
    bench.fly(0.5)
    assert bench.session.controller.text == text
    with pytest.raises(WorkbenchError, match="reset it first"):
        bench.flying.do(_order(Action(controller="lqi")))
    del bench.session.tick
    bench.flying.do(_order(FlightOrder.RESET))
    bench.fly(0.5)
    assert bench.session.controller.text == TEXT


def _broken(duration: float) -> None:
    raise WorkbenchError("the flight broke off")


def _order(what):
    from workbench.ipc.worker_process import WorkerRequest

    return WorkerRequest(1, what)


def test_what_was_flown_is_a_scenario_that_can_be_saved_and_flown_with_the_same_file(
    mine, tmp_path
):
    bench = Bench(Scenario(controller=str(mine)))
    bench.fly(0.25)
    in_place(mine, TEXT + "# edited\n")
    bench.fly(0.5)
    flown = bench.flying._flown()
    assert [action.controller for action in flown.scenario.script] == [str(mine)]
    save_scenario(flown.scenario, tmp_path / "again.yaml")
    with pytest.raises(WorkbenchError, match="Python code that would run here"):
        load_scenario(tmp_path / "again.yaml")
    again = Session(load_scenario(tmp_path / "again.yaml", str(mine)))
    again.run()
    assert again.recording().v_WB.tobytes() == flown.recording.v_WB.tobytes()
    text = (tmp_path / "again.yaml").read_text(encoding="utf-8")
    other = tmp_path / "other.py"
    other.write_text("raise SystemExit('it ran')\n", encoding="utf-8")
    (tmp_path / "again.yaml").write_text(
        text.replace(f"  controller: {mine}", f"  controller: {other}"), encoding="utf-8"
    )
    with pytest.raises(
        WorkbenchError, match=r"again\.yaml:\d+: .*other\.py is Python code that would"
    ):
        load_scenario(tmp_path / "again.yaml", str(mine))


def test_a_real_flight_follows_its_file_and_its_log_flies_it_again(mine, tmp_path, case):
    log = tmp_path / "flight.mcap"
    with LiveFlight(Scenario(controller=str(mine)), watch=True) as flight:
        flight.wait(ENOUGH)
        flight.keep_log(log).result(ENOUGH)
        flight.set("k_tilt", 110.0).result(ENOUGH)
        flight.command([1.0, 0.0, 0.0]).result(ENOUGH)
        bad = (
            (in_place, TEXT.replace("def update(", "def update(:"), "is not valid Python"),
            (renamed, TEXT.replace("f, w = into_body", "f, w = into_bdy"), "NameError"),
        )
        for save, text, said in bad:
            with case(said):
                save(mine, text)
                wait_for(lambda said=said: remarks_with(said, flight))
                (remark,) = remarks_with(said, flight)
                assert remark.startswith(f"{mine}:") and remark.endswith("mine flies on as it was")
                assert flight.latest().controller.text == TEXT
        for save, k_yaw in ((in_place, 4.0), (renamed, 5.0)):
            text = TEXT.replace('3.0, "angular', f'{k_yaw}, "angular') + f"# {k_yaw}\n"
            save(mine, text)
            wait_for(lambda text=text: flight.latest().controller.text == text)
        values = flight.latest().values
        assert values["k_tilt"] == 110.0 and values["k_yaw"] == 3.0
        with pytest.raises(WorkbenchError, match="unknown controller 'lqq'"):
            flight.fly_controller("lqq").result(ENOUGH)
        twice = [flight.fly_controller(name) for name in ("pid", "lqi")]
        assert twice[0].result(ENOUGH) <= twice[1].result(ENOUGH)
        assert flight.latest().controller.name == flight.latest().scenario.controller == "lqi"
        at = twice[1].result()
        wait_for(lambda: flight.latest().snapshot.time > at + 0.1)
        assert flight.latest().phase is Phase.FLYING
        flight.stop_log().result(ENOUGH)
    record = read_log(log)
    assert len(record.laws) >= 2
    for controller in ("", str(mine)):
        with pytest.raises(WorkbenchError, match=f"as --controller {log}"):
            replay(record, controller=controller)
    found = replay(record, controller=str(log))
    assert found.equal and found.states == len(record.states)
