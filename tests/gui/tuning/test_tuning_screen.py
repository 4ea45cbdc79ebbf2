import dataclasses

import control
import numpy as np
import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtWidgets import QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit

from workbench.analysis.queries import FindRanges, Judge, Predict, RequestedStep, Tune
from workbench.control.loop import loop_label
from workbench.gui.gains.gain_file_diff_view import GainFileDiffView
from workbench.gui.tuning.excitation_card import FAULT_TAB
from workbench.gui.tuning.excitation_form import loop_excitation
from workbench.gui.tuning.number_row import RowState
from workbench.gui.tuning.response_card import (
    AHEAD_CURVE,
    COMMAND_CURVE,
    FLOWN_CURVE,
    PREDICTED_CURVE,
)
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS_SIGNAL, fixed_topic
from workbench.live.choice import Choice
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape
from workbench.scenario.scenario import Action

PARAMETERS = fixed_topic(PARAMETERS_SIGNAL.id)
WIDE, NARROW = (1190, 600), (760, 600)


@pytest.fixture
def screen(screen):
    screen.resize(*WIDE)
    return screen


def fly(screen, canned, exciting=None):
    """Show all of a canned flight, excited from its beginning on."""
    screen.workspace.signals.begin(canned.views[0].topics)
    for view, published in zip(canned.views, canned.published, strict=True):
        screen.workspace.signals.add(published)
        screen.show_view(dataclasses.replace(view, exciting=exciting))


def test_margins_sliders_and_response_are_seen_together(screen):
    """In a window of 1280 x 720, the margins are a line."""
    for part in (screen.panel, screen.response, screen.margins):
        assert part.isVisible()
        corner = part.mapTo(screen, part.rect().bottomRight())
        assert corner.x() <= WIDE[0] and corner.y() <= WIDE[1]


def test_beside_a_picture_it_is_one_card_at_a_time(screen, qtbot):
    screen.resize(*NARROW)
    qtbot.waitUntil(lambda: not screen.response.isVisible())
    assert screen.width() == NARROW[0]
    assert [screen.tabs.tabText(index) for index in range(3)] == ["Gains", "Step", "Margins"]
    assert screen.panel.isVisible() and not screen.margins.isVisible()
    screen.tabs.setCurrentIndex(2)
    assert screen.margins.table.isVisible() and not screen.panel.isVisible()
    screen.resize(*WIDE)
    assert screen.panel.isVisible() and screen.response.isVisible()


def answer(screen, judge, predict, qtbot):
    """Answer what a screen asks at first."""
    analysis = screen.workspace.analysis
    qtbot.waitUntil(lambda: bool(analysis.of(Predict)) and bool(analysis.of(Judge)))
    asked = analysis.of(Predict)[0]
    analysis.tell(*predict(asked.gains, asked.step))
    analysis.tell(*judge(asked.gains))


def test_a_proposed_gain_is_judged_and_predicted_before_it_flies(
    screen, offline, judge, predict, qtbot
):
    answer(screen, judge, predict, qtbot)
    screen.gains.propose("kp_velocity_x", 7.0)
    qtbot.waitUntil(lambda: len(offline.analysis.of(Predict)) == 2)
    predict = offline.analysis.of(Predict)[-1]
    assert predict.gains["kp_velocity_x"] == 7.0
    assert predict.step == RequestedStep("x", 1.0, 2.0)
    assert offline.analysis.of(Judge)[-1].gains["kp_velocity_x"] == 7.0
    assert not any(isinstance(order, Action) for order in offline.flight.orders)


def test_the_prediction_is_drawn_and_its_numbers_stand_in_the_table(
    screen, offline, predict, qtbot
):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Predict)))
    asked = offline.analysis.of(Predict)[-1]
    offline.analysis.tell(*predict(asked.gains, asked.step))
    assert PREDICTED_CURVE in screen.response.plot.names
    overshoot = screen.response.table.rows[1]
    assert (overshoot.cells[1].text, overshoot.cells[1].over) == ("12.0", True)
    assert overshoot.state is RowState.NONE


def test_the_way_that_is_flown_ahead_goes_to_the_3_d_view(screen):
    heard = []
    screen.workspace.scene.foreseen.connect(lambda ends, places: heard.append((ends, len(places))))
    screen.ghost.foreseen.emit(3.0, np.zeros((4, 3)))
    assert heard == [(3.0, 4)]


def test_a_step_is_predicted_with_the_heading_at_which_its_round_began(
    screen, offline, canned, flying, judge, predict, qtbot
):
    answer(screen, judge, predict, qtbot)
    fly(screen, canned)

    def turned(yaw, exciting=None):
        attitude = (*flying.snapshot.roll_pitch_yaw[:2], yaw)
        snapshot = dataclasses.replace(flying.snapshot, roll_pitch_yaw=attitude)
        return dataclasses.replace(flying, snapshot=snapshot, exciting=exciting)

    screen.show_view(turned(-1.45))
    qtbot.waitUntil(
        lambda: offline.analysis.of(Predict)[-1].step == RequestedStep("x", 1.0, 2.0, -1.45)
    )
    begun = ActiveExcitation(screen.excitation.choice.excitation, began=1.0, round=1)
    for yaw in (0.7, 0.9):  # the drone turns while the round is flown
        screen.show_view(turned(yaw, begun))
        assert screen.trial.step.heading == 0.7


def test_what_a_prediction_waits_for_is_told(screen, offline, predict, qtbot):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Predict)))
    for said, shown in (
        ("compiling flights for this machine, up to a minute, this once", "up to a minute"),
        (
            "compiling flights: 40 %, 8 s",
            "about 12\N{NO-BREAK SPACE}s",
        ),  # 8 s are 40 %, so all are 20 s
    ):
        offline.analysis.preparing.emit(said)
        assert f"Preparing predictions, {shown}" in screen.response.said.text()
    asked = offline.analysis.of(Predict)[-1]
    offline.analysis.tell(*predict(asked.gains, asked.step))
    assert "Preparing" not in screen.response.said.text()
    offline.analysis.preparing.emit("compiling something else")
    assert "Preparing" not in screen.response.said.text()


def test_a_lost_prediction_is_told(screen, offline, predict, qtbot):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Predict)))
    asked = offline.analysis.of(Predict)[-1]
    offline.analysis.tell(*predict(asked.gains, asked.step, lost=True))
    assert screen.response.said.text() == "The drone crashes with the proposed gains."
    assert PREDICTED_CURVE not in screen.response.plot.names


def test_a_flown_step_has_the_numbers_of_python_control(screen, canned):
    """The canned flight steps to 2 m/s after 1 s."""
    screen.excitation.choice = dataclasses.replace(screen.excitation.choice, period=1.5)
    exciting = ActiveExcitation(
        screen.excitation.choice.with_amplitude(2.0).excitation, began=1.0, round=1
    )
    fly(screen, canned, exciting)
    time, speed = screen.workspace.signals.series("velocity_data.v_x", 1.0 - 1e-6)
    flown = time <= 2.5 + 1e-6
    info = control.step_info(speed[flown], T=time[flown] - 1.0)
    numbers = screen.response.history.numbers
    assert numbers.rise_time == pytest.approx(info["RiseTime"])
    assert numbers.overshoot == pytest.approx(info["Overshoot"])
    assert numbers.settling_time == pytest.approx(info["SettlingTime"], nan_ok=True)
    assert FLOWN_CURVE in screen.response.plot.names
    assert COMMAND_CURVE in screen.response.plot.names
    assert screen.response.table.rows[0].cells[0].text == f"{info['RiseTime']:.3f}"
    assert [use.label for use in screen.response.strip.uses] == ["tilt", "rotor use", "speed"]


def test_nothing_is_asked_while_the_screen_is_not_seen(screen, offline, judge, predict, qtbot):
    answer(screen, judge, predict, qtbot)
    screen.hide()
    screen.trial.set_step(RequestedStep("y", 1.0, 2.0))
    qtbot.wait(50)
    assert len(offline.analysis.of(Predict)) == len(offline.analysis.of(Judge)) == 1
    screen.show()
    qtbot.waitUntil(lambda: offline.analysis.of(Predict)[-1].step.axis == "y")


def test_a_chirp_has_nothing_to_predict(screen):
    screen.excitation.shape.activated.emit(tuple(Shape).index(Shape.CHIRP))
    assert screen.trial.step is None
    assert screen.response.said.text() == "A chirp has no step to measure."
    assert not screen.pin.button.isEnabled()


def test_every_control_has_a_name_and_can_be_reached_by_keyboard(screen):
    cards = (screen.excitation, screen.response, screen.margins, screen.map, screen.weights)
    for card in (*cards, screen.fork, screen.autotune, screen.pin):
        for kind in (QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit):
            for each in card.findChildren(kind):
                inner = isinstance(each.parent(), QAbstractSpinBox | QComboBox)
                if each.objectName().startswith("qt_") or inner:
                    continue
                named = each.accessibleName() or getattr(each, "text", str)()
                assert named, (card, each)
                assert each.focusPolicy() & Qt.FocusPolicy.TabFocus, (card, each)


@pytest.mark.slow
def test_a_real_flight_is_excited_measured_and_judged(workspace, qtbot):
    screen = TuningScreen(workspace)
    qtbot.addWidget(screen)
    screen.resize(*WIDE)
    screen.show()
    workspace.flight.begun.connect(
        lambda view: workspace.analysis.begin(view.scenario, view.values)
    )
    workspace.flight.begun.connect(screen.begin)
    workspace.flight.viewed.connect(screen.show_view)
    workspace.flight.fly(Choice("hover"), draw=False)
    qtbot.waitUntil(lambda: screen.excitation.button.isEnabled(), timeout=60000)
    screen.excitation.repeats.setChecked(False)
    screen.excitation.start_or_stop()
    qtbot.waitUntil(lambda: screen.response.history.numbers is not None, timeout=60000)
    qtbot.waitUntil(lambda: len(screen.margins.table.rows) == 10, timeout=60000)
    qtbot.waitUntil(lambda: screen.judgement.inputs[0] is not None, timeout=60000)
    qtbot.waitUntil(lambda: not screen.excitation.is_running, timeout=60000)
    numbers, begun = screen.response.history.numbers, screen.response.history.round.begun
    time, speed = workspace.signals.series("velocity_data.v_x", begun - 1e-6)
    flown = time <= begun + 2.0 + 1e-6
    info = control.step_info(speed[flown], T=time[flown] - begun)
    assert numbers.rise_time == pytest.approx(info["RiseTime"])
    assert numbers.settling_time == pytest.approx(info["SettlingTime"])
    assert numbers.overshoot == pytest.approx(info["Overshoot"])
    assert 0.2 < numbers.rise_time < 0.5
    screen.close_screen()


def test_a_prediction_that_is_refused_leaves_none_of_earlier_gains(
    screen, offline, judge, predict, qtbot
):
    answer(screen, judge, predict, qtbot)
    assert PREDICTED_CURVE in screen.response.plot.names
    screen.gains.propose("kp_velocity_x", 7.0)
    qtbot.waitUntil(lambda: len(offline.analysis.of(Predict)) == 2)
    offline.analysis.refused.emit(offline.analysis.of(Predict)[-1], "its process has died")
    assert PREDICTED_CURVE not in screen.response.plot.names
    assert screen.response.said.text() == "No prediction: its process has died"
    assert screen.response.table.rows[0].cells[1].text == "–"


def test_what_lies_ahead_is_shown_as_far_as_its_command_holds(screen):
    card = screen.response
    card.history.begin(ActiveExcitation(Excitation("x", Shape.STEP, 1.0, 2.0, True), 10.0, 1), {})
    time = 11.0 + np.linspace(0.0, 5.0, 501)
    card.show_ahead(time, np.zeros(501))
    assert AHEAD_CURVE in card.plot.names
    curve = card.plot.curves[card.plot.names.index(AHEAD_CURVE)]
    shown, _ = curve.samples(0.0)
    assert (shown[0], shown[-1]) == pytest.approx((1.0, 2.0))
    card.show_ahead(time - 2.0, np.zeros(501))  # from before the round began
    assert AHEAD_CURVE not in card.plot.names


def test_the_response_to_an_attitude_step_ends_where_the_loops_outside_fly_back(screen):
    screen.excitation.tabs.setCurrentIndex(1)
    assert screen.excitation.choice.axis == "roll"
    screen.response.plot.redraw()
    assert screen.response.plot.window_ends == (0.0, screen.excitation.choice.period)


def test_a_loaded_gain_file_has_room_in_a_low_window(screen, canned, qtbot):
    """In a window of 1280 x 720 its lines and buttons stand in place of the gains."""
    fly(screen, canned)
    view = screen.findChild(GainFileDiffView)
    screen.gain_files.paste(
        "gains: {kp_pitch: 150.0, kp_roll: 150.0, kd_pitch: 20.0, kd_roll: 20.0}"
    )
    qtbot.waitUntil(view.isVisible)
    view.said.setText(20 * "a remark of the file ")
    buttons, rows = (view.fly, view.none), [*view.ticks.values()]
    qtbot.waitUntil(lambda: view.said.height() >= view.said.heightForWidth(view.said.width()) > 30)
    assert len(rows) == 4 and not screen.panel.isVisible()
    lowest = max(row.mapTo(view, row.rect().bottomLeft()).y() for row in rows)
    assert all(button.mapTo(view, QPoint()).y() > lowest for button in buttons)
    assert screen.diff_margins.is_folded and screen.diff_margins.geometry().bottom() <= WIDE[1]
    screen.gain_files.dismiss()
    assert screen.panel.isVisible()


@pytest.fixture
def begun(offline, monkeypatch):
    """Settings with which the analyst began anew."""
    begun = []

    def begin(scenario, settings, law):
        begun.append(settings)
        return True

    monkeypatch.setattr(offline.analysis, "begin", begin)
    return begun


@pytest.fixture
def publish(offline):
    """Publishes changes of parameters, as a flight does."""

    def published(*changes):
        packed = [(PARAMETERS_SIGNAL.id, PARAMETERS.pack([*change])) for change in changes]
        offline.flight.streamed.emit([Published(0, 0, tuple(packed))])

    return published


def test_a_gain_that_is_judged_while_the_vehicle_changes_is_judged_again(
    screen, offline, judge, begun, publish, qtbot
):
    """And flies once it is stable; ranges are found anew."""
    offline.preferences.set("apply_gains", "at once")
    screen.gains.propose("kp_velocity_x", 7.0)
    assert screen.gains.unflown == ("kp_velocity_x",)
    qtbot.waitUntil(lambda: not screen.gains._stability._rest.isActive())  # of the first ranges
    asked = len(offline.analysis.asked)
    publish(("payload_mass", 0.25))
    qtbot.waitUntil(lambda: bool(begun))

    def again(kind):
        return [each for each in offline.analysis.asked[asked:] if isinstance(each, kind)]

    qtbot.waitUntil(lambda: any(each.gains["kp_velocity_x"] == 7.0 for each in again(Judge)))
    qtbot.waitUntil(lambda: bool(again(FindRanges)))
    for question in again(Judge):
        offline.analysis.tell(question, judge(question.gains)[1])
    orders = [each.set for each in offline.flight.orders if isinstance(each, Action)]
    assert {"kp_velocity_x": 7.0} in orders


def test_a_search_goes_on_while_the_vehicle_changes(screen, offline, judge, begun, publish, qtbot):
    """The vehicle is judged anew after it; until then the margins say of which vehicle they are."""
    offline.analysis.tell(*judge(screen.trial.judged_flown))
    assert screen.margins.said.text().startswith("Weakest:")
    screen.autotune.search()
    assert screen.autotune.is_running
    screen._vehicle_rest.setInterval(1)
    publish(("payload_mass", 0.25))
    with qtbot.waitSignal(screen._vehicle_rest.timeout):
        pass
    assert screen.autotune.is_running and screen._vehicle_rest.isActive() and not begun
    assert screen.margins.said.text() == (
        "Of the vehicle before its payload changed: judged anew once the search or the fork has "
        "ended."
    )
    (question,) = offline.analysis.of(Tune)
    offline.analysis.refused.emit(question, "enough")
    qtbot.waitUntil(lambda: bool(begun))
    assert not screen.judgement.caveat


def test_a_vehicle_that_is_as_before_is_not_judged_anew(screen, offline, judge, publish, qtbot):
    shown = []
    offline.analysis.tell(*judge(screen.trial.judged_flown))
    before = screen.judgement.proposed
    offline.analysis.begin(offline.flight.view.scenario, offline.flight.view.values)
    screen.judgement.changed.connect(lambda: shown.append(screen.margins.said.text()))
    screen._vehicle_rest.setInterval(1)
    publish(("payload_mass", 0.25))
    publish(("payload_mass", 0.0))
    with qtbot.waitSignal(screen._vehicle_rest.timeout):
        pass
    assert shown[0] == "Of the vehicle before its payload changed: judged anew soon."
    assert shown[-1].startswith("Weakest:") and screen.judgement.proposed is before


@pytest.fixture
def loaded(screen, offline, judge, qtbot):
    """The screen with answers about a loaded gain file, which waits for a choice."""
    screen._vehicle_rest.setInterval(1)
    offline.analysis.begin(offline.flight.view.scenario, offline.flight.view.values)
    offline.analysis.tell(*judge(screen.trial.judged_flown))
    screen.gain_files.paste("gains: {kp_pitch: 150.0}")
    qtbot.waitUntil(screen.diff_margins.isVisible)
    for question in offline.analysis.of(Judge):
        offline.analysis.tell(question, judge(question.gains)[1])
    assert screen.diff_margins.said.text().startswith("Weakest:")
    return screen


def test_a_loaded_gain_file_is_judged_anew_with_the_vehicle(
    loaded, offline, judge, make_loop, publish, qtbot
):
    asked = len(offline.analysis.of(Judge))
    publish(("payload_mass", 0.25))
    said = "Of the vehicle before its payload changed: judged anew soon."
    assert loaded.diff_margins.said.text() == loaded.margins.said.text() == said

    def again():
        return [each.gains["kp_pitch"] for each in offline.analysis.of(Judge)[asked:]]

    qtbot.waitUntil(lambda: 150.0 in again())
    assert loaded.diff_judgement.proposed is None
    weak = make_loop("roll", phase_margin=np.radians(20.0))
    asked, judged = judge({**loaded.trial.judged_flown, "kp_pitch": 150.0}, weak)
    offline.analysis.tell(asked, judged)
    assert loaded.diff_margins.said.text().startswith("Weakest: roll")


def test_a_loaded_gain_file_of_a_vehicle_that_is_as_before_is_of_it(
    loaded, offline, publish, qtbot
):
    publish(("payload_mass", 0.25))
    publish(("payload_mass", 0.0))
    with qtbot.waitSignal(loaded._vehicle_rest.timeout):
        pass
    assert loaded.diff_margins.said.text().startswith("Weakest:")


def test_the_vehicle_that_changed_is_of_the_flight(screen, offline, flying, judge, publish, qtbot):
    """After a controller took over nothing has changed since; in another flight nothing waits."""
    screen._vehicle_rest.setInterval(50)
    screen.autotune.search()
    publish(("payload_mass", 0.25))
    screen.take_over(flying)
    screen.autotune.search()
    offline.analysis.tell(*judge(screen.trial.judged_flown))
    with qtbot.waitSignal(screen._vehicle_rest.timeout):
        pass
    assert not screen.judgement.caveat
    assert screen._vehicle_rest.isActive()  # for after the search
    screen.begin(flying)
    assert not screen._vehicle_rest.isActive()


def test_unstable_gains_are_told_of_an_earlier_vehicle_too(
    screen, offline, judge, make_loop, begun, publish
):
    unstable = make_loop("roll", stable=False)
    offline.analysis.tell(*judge(screen.trial.judged_flown, unstable, poles=(1.0, -2.0)))
    note = "Of the vehicle before its payload changed: judged anew soon."
    said = f"The closed loop is unstable with these gains. {note}"
    publish(("payload_mass", 0.25))
    assert screen.margins.said.text() == said
    assert screen.margins.said.property("class") == "bad"
    screen.tabs.setCurrentWidget(screen.frequency)
    screen.frequency.show_view("Phase")
    assert screen.frequency.phase.headline == (said, "bad")
    screen.tabs.setCurrentWidget(screen.poles)
    assert screen.poles.said.text() == f"1 unstable pole. {note}"
    assert screen.poles.said.property("class") == "bad"


def test_what_the_drone_carries_and_how_its_joints_stand_is_judged_anew(
    screen, offline, flying, begun, publish, qtbot
):
    """Once it has not changed for a moment; a gain is part of each question."""
    vehicle = dataclasses.replace(flying.vehicle, name="slung")
    values = {**flying.values, "open_hooks": 0.0}
    slung = dataclasses.replace(flying, vehicle=vehicle, values=values)
    offline.flight.show(slung)
    screen.begin(slung)
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Judge)))
    asked = len(offline.analysis.of(Judge))
    publish(("wind_x", 2.0), ("kp_roll", 200.0))
    assert not screen._vehicle_rest.isActive()
    publish(("payload_mass", 0.25), ("open_hooks", 1.0))
    publish(("payload_mass", 0.5))
    qtbot.waitUntil(lambda: bool(begun))
    assert begun == [{**slung.values, "payload_mass": 0.5, "open_hooks": 1.0}]
    qtbot.waitUntil(lambda: len(offline.analysis.of(Judge)) > asked)


def test_one_click_chooses_a_step_of_the_weakest_loop(screen, judge, make_loop, qtbot):
    """Whatever tab is in front; a loop without a setpoint of its own has none."""
    analysis, excite = screen.workspace.analysis, screen.margins.excite
    qtbot.waitUntil(lambda: bool(analysis.of(Judge)))
    flown = screen.trial.judged_flown
    assert not excite.isEnabled()
    analysis.tell(*judge(flown, make_loop("pitch", phase_margin=np.radians(30.0))))
    screen.tabs.setCurrentWidget(screen.poles)
    screen.excitation.choose_loop("pitch")
    screen.excitation.shape.activated.emit(tuple(Shape).index(Shape.CHIRP))
    assert screen.excitation.choice.shape is Shape.CHIRP
    screen.excitation.choose_loop("yaw_rate")
    qtbot.mouseClick(excite, Qt.MouseButton.LeftButton)
    choice = screen.excitation.choice
    assert (choice.kind.name, choice.axis, choice.shape) == ("Attitude", "pitch", Shape.STEP)
    assert screen.excitation.axis.currentText() == "pitch" and screen.excitation.isVisible()
    assert screen.trial.setpoint_step.axis == "pitch"
    screen.gains.propose("kp_velocity_z", 9.0)
    qtbot.waitUntil(lambda: analysis.of(Judge)[-1].gains["kp_velocity_z"] == 9.0)
    weak = make_loop("velocity_z", phase_margin=np.radians(20.0))
    analysis.tell(*judge(screen.trial.judged, weak))
    qtbot.mouseClick(excite, Qt.MouseButton.LeftButton)
    assert (screen.excitation.choice.kind.name, screen.excitation.choice.axis) == ("Setpoint", "z")
    assert loop_excitation("yaw_rate")[1] == "yaw"


def test_a_button_that_chooses_no_step_says_why(screen, canned, judge, make_loop, flying, qtbot):
    """As tool tip, and for screen readers."""
    screen.workspace.signals.begin(canned.views[0].topics)
    analysis, excite = screen.workspace.analysis, screen.margins.excite

    def said():
        assert excite.isEnabled() == (not excite.accessibleDescription())
        assert excite.toolTip() == (excite.accessibleDescription() or excite.accessibleName())
        return excite.accessibleDescription()

    qtbot.waitUntil(lambda: bool(analysis.of(Judge)))
    assert said() == "The weakest loop is not known yet"
    weak = {"phase_margin": np.radians(20.0)}
    analysis.tell(*judge(screen.trial.judged_flown, make_loop("pitch", **weak)))
    assert said() == ""
    running = ActiveExcitation(Excitation("x", Shape.STEP, 1.0, 2.0), 0.0, 1)
    screen.show_view(dataclasses.replace(flying, exciting=running))
    assert said() == "An excitation runs: stop it first"
    screen.show_view(flying)
    assert said() == ""
    for loop in ("position_x", "heading"):  # as geometric has
        assert loop_excitation(loop) is None
        asked, judged = judge(screen.trial.judged_flown)
        loops = (*judged.loops, make_loop(loop, **weak))
        analysis.tell(asked, dataclasses.replace(judged, loops=loops))
        screen.judgement.follow(screen.trial.judged, screen.trial.judged_flown)
        assert f"the weakest loop, {loop_label(loop)}: choose another one" in said()


def test_the_fault_card_shows_what_a_script_or_a_client_made_fail(screen, publish):
    screen.excitation.tabs.setCurrentIndex(FAULT_TAB)
    assert screen.excitation.said.text() == "Nothing has failed."
    publish(("rotor_2", 0.9))
    assert screen.excitation.said.text() == "Failed: rotor 2 at 90 %."
    form = screen.excitation.fault
    form.part.setCurrentText("rotor 2")
    assert form.repair.isEnabled()
