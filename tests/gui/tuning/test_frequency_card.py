"""One loop over frequency: the card's curves against python-control's, its numbers the table's."""

import math
from functools import partial

import control
import numpy as np
import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtTest import QTest

from workbench.analysis.judging import draw_frequency
from workbench.analysis.judging import judge as judge_loops
from workbench.analysis.questions import DrawFrequency, Judge
from workbench.analysis.subject import Subject
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.margins import LoopMargins
from workbench.design.linear.linearize import linearize
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.drawn_loop import (
    DrawnLoop,
    drawn_curves,
    drawn_measurement,
    gain_margin_mark,
    peak,
    phase_margin_mark,
)
from workbench.gui.tuning.loop_plots import disk
from workbench.scenario.scenario import Scenario

NOTHING = np.empty(0)


class Answerer:
    """Answers what a screen has asked a listening analyst, as the analyst's process would."""

    def __init__(self, analysis) -> None:
        self._analysis = analysis
        self._subject = Subject(Scenario(), {})
        self._done = 0

    def answer(self) -> bool:
        """Answer what waits; return whether there was something."""
        waiting = self._analysis.asked[self._done :]
        self._done = len(self._analysis.asked)
        for question in waiting:
            if isinstance(question, Judge):
                (reply,) = judge_loops(self._subject, question, None)
                self._analysis.tell(question, reply)
            elif isinstance(question, DrawFrequency):
                (reply,) = draw_frequency(self._subject, question, None)
                self._analysis.tell(question, reply)
        return bool(waiting)


@pytest.fixture
def settle(offline, qtbot):
    """Returns what answers until nothing is asked any more and something is so."""
    answerer = Answerer(offline.analysis)

    def until(so):
        qtbot.waitUntil(lambda: not answerer.answer() and so(), timeout=30_000)

    return until


def shows(card, *names):
    """Whether these curves are known."""
    return set(card.curves.shown) == set(names)


def row(screen, loop):
    return next(each for each in screen.margins.table.rows if each.label == loop)


def caption(plot):
    plot.redraw()
    return plot.canvas.content.caption


def curve(plot, name):
    """Frequencies [rad/s] and values of a curve that is drawn."""
    found = next(each for each in plot.curves if each.label == name)
    return found.samples(-math.inf)


def test_the_weakest_loop_is_drawn_and_follows_the_slider_with_the_tables_numbers(
    screen, settle, offline
):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    weakest = next(each.label for each in screen.margins.table.rows if each.strong)
    assert card.loops.currentText().replace("velocity", "vel.") == weakest
    card.choose_loop("pitch")
    settle(lambda: shows(card, "flown"))
    flown = screen.gains.flown
    for kp in (1.2, 1.6):
        moved = {"kp_pitch": kp * flown["kp_pitch"], "kd_pitch": 0.9 * flown["kd_pitch"]}
        for name, value in moved.items():
            screen.gains.propose(name, value)
        settle(lambda value=moved["kp_pitch"]: _is_of(offline, card, "proposed", value))
        gains = {name: screen.gains.proposed[name] for name in moved}
        magnitude, phase = card.bode.plots
        frequency, size = curve(magnitude, "proposed")
        response = linearize(loop="pitch", gains=gains)(np.exp(1j * frequency / 128.0))
        np.testing.assert_allclose(size, 20.0 * np.log10(np.abs(response)), atol=1e-6)
        turn = np.radians(curve(phase, "proposed")[1])
        np.testing.assert_allclose(np.exp(1j * turn), response / np.abs(response), atol=1e-6)
        rise, fall, phase_margin, _, disk_margin = row(screen, "pitch").cells
        assert f"gain\N{NO-BREAK SPACE}+ {rise.text} dB" in caption(magnitude)
        assert f"gain\N{NO-BREAK SPACE}− {fall.text} dB" in caption(magnitude)
        assert caption(phase) == f"phase {phase_margin.text}°"
        assert card.said.text().startswith(f"{phase_margin.text}° at")
        _, upright, up, down = magnitude.canvas.content.guides
        margin = 20.0 * np.log10(np.interp(upright.x[0], frequency, np.abs(response)))
        assert margin == pytest.approx(0.0, abs=0.1), "the crossover's line stands where |L| is 1"
        assert -up.y[0] == pytest.approx(float(rise.text), abs=0.1)
        assert down.y[0] == pytest.approx(float(fall.text), abs=0.1)
        level, there = phase.canvas.content.guides[1].y
        assert abs(there - level) == pytest.approx(float(phase_margin.text), abs=0.1)
        card.show_view("Nyquist")
        assert card.nyquist.canvas.content.caption == f"disk {disk_margin.text}"
        card.show_view("Bode")
    assert [each.style for each in magnitude.curves] == [CurveStyle.SOLID, CurveStyle.DASHED]


def asked_about(offline, card, name):
    """Return the question that the shown curves of a set answer."""
    curves, analysis = card.curves.shown[name], offline.analysis
    return next(each for each in analysis.of(DrawFrequency) if analysis.known(each) is curves)


def _is_of(offline, card, name, kp):
    shown = name in card.curves.shown
    return shown and asked_about(offline, card, name).gains["kp_pitch"] == kp


def test_what_was_kept_stands_beside_what_flies_and_what_is_proposed(screen, settle, offline):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.choose_loop("pitch")
    gains, name = screen.gains, "kp_pitch"
    own = gains.flown[name]
    gains.propose(name, 1.2 * own)
    gains.apply()
    settle(lambda: gains.flown[name] != own)
    gains.propose(name, 1.4 * own)
    settle(lambda: shows(card, "flown", "proposed", "kept"))
    found = {each: asked_about(offline, card, each).gains[name] / own for each in card.curves.shown}
    assert found == pytest.approx({"flown": 1.2, "proposed": 1.4, "kept": 1.0})
    assert [each.label for each in card.legend.entries] == ["flown", "proposed", "kept"]
    magnitude, _ = card.bode.plots
    assert magnitude.names == ("flown", "proposed", "kept")


def test_a_row_of_the_table_of_margins_chooses_its_loop(screen, settle, offline):
    card, table = screen.frequency, screen.margins.table
    settle(lambda: shows(card, "flown"))
    names = [each.label for each in table.rows]
    height = table._row_height()
    at = QPoint(20, round((names.index("yaw rate") + 1.5) * height))
    QTest.mouseClick(table, Qt.MouseButton.LeftButton, pos=at)
    assert card.curves.loop == "yaw_rate"
    settle(lambda: shows(card, "flown"))
    assert asked_about(offline, card, "flown").loop == "yaw_rate"
    below = QPoint(20, round((len(names) + 0.5) * height))  # the plant's input is no loop
    QTest.mouseClick(table, Qt.MouseButton.LeftButton, pos=below)
    assert card.curves.loop == "yaw_rate"


def test_the_four_have_units_and_named_peaks(screen, settle):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.choose_loop("velocity_x")
    settle(lambda: shows(card, "flown"))
    card.show_view("Gang of four")
    known = card.curves.shown["flown"]
    four = (
        known.sensitivity,
        known.complementary_sensitivity,
        known.control_sensitivity,
        known.load_sensitivity,
    )
    for plot, wanted in zip(card.gang.plots, four, strict=True):
        np.testing.assert_allclose(curve(plot, "flown")[1], np.abs(wanted))
    judged = known.margins
    assert caption(card.gang.plots[0]).startswith(f"Ms {np.abs(known.sensitivity).max():.3g} at")
    assert judged.stable
    for plot in card.gang.plots:
        plot.redraw()
    units = [plot.canvas.content.axes[0].unit.symbol for plot in card.gang.plots]
    assert units == ["", "", "(m/s²)/(m/s)", "(m/s)/(m/s²)"]


def test_another_cut_is_asked_for_and_a_refusal_is_told(screen, settle, offline):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.cuts.setCurrentText("error")
    card.cuts.activated.emit(1)
    assert offline.analysis.of(DrawFrequency)[-1].cut == "error"
    offline.analysis.refused.emit(offline.analysis.of(DrawFrequency)[-1], "no such flight")
    assert card.said.text() == "Not known: no such flight"


def test_nothing_is_asked_while_nobody_looks(screen, settle, offline):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    asked = len(offline.analysis.of(DrawFrequency))
    for hide in (partial(card.show_view, "Phase"), partial(screen.tabs.setCurrentIndex, 1)):
        hide()
        screen.gains.propose("kp_roll", 1.01 * screen.gains.proposed["kp_roll"])
        wanted = screen.gains.proposed["kp_roll"]
        settle(lambda value=wanted: screen.judgement.gains["kp_roll"] == value)
        assert len(offline.analysis.of(DrawFrequency)) == asked
    screen.tabs.setCurrentWidget(card)
    card.show_view("Bode")
    settle(lambda: shows(card, "flown", "proposed"))


def test_an_unstable_loop_is_drawn_without_margins(screen, settle, offline):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.choose_loop("pitch")
    screen.gains.propose("kd_pitch", 1.0)
    screen.gains.propose("kp_pitch", 900.0)
    settle(lambda: _is_of(offline, card, "proposed", 900.0))
    assert card.said.text() == "The closed loop is unstable with these gains."
    assert caption(card.bode.plots[0]) == ""
    assert len(curve(card.bode.plots[0], "proposed")[0]) > 200


def test_the_cursor_reads_size_and_phase_in_all_views(screen, settle):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.choose_loop("pitch")
    settle(lambda: shows(card, "flown"))
    card.set_cursor(20.0)
    response = linearize(loop="pitch", gains={})(np.exp(20.0j / 128.0))
    turn = math.degrees(np.angle(response))
    size = 20.0 * math.log10(abs(response))
    said = f"L at 20 rad/s:  {size:.1f} dB {turn:.0f}°".replace("-", "−")
    assert card.reading.text() == said
    assert [plot.cursor_time for plot in card.bode.plots] == [20.0, 20.0]
    card.show_view("Nyquist")
    (point,) = card.nyquist.canvas.content.points
    assert complex(point.x, point.y) == pytest.approx(response, rel=1e-3)
    card.nyquist._point(response + 0.001)
    assert card._cursor == pytest.approx(20.0, rel=0.03)


def test_both_plots_of_bode_show_the_same_frequencies_and_their_data_say_so(screen, settle):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    magnitude, phase = card.bode.plots
    magnitude.redraw()
    magnitude.set_cursor(10.0)
    magnitude.zoom_by(0.5)
    assert phase.window_ends != magnitude.window_ends
    phase.redraw()
    assert phase.window_ends == pytest.approx(magnitude.window_ends)
    phase.reset()
    magnitude.redraw()
    assert phase.window_ends == pytest.approx(magnitude.window_ends)
    magnitude.copy_data()
    assert QGuiApplication.clipboard().text().startswith("frequency [rad/s]\tflown [dB]\n")


def test_a_measured_loop_is_drawn_where_it_is_coherent(screen, settle):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.choose_loop("pitch")
    settle(lambda: shows(card, "flown"))
    frequency = np.array([1.0, 5.0, 10.0, 50.0])
    coherence = np.array([0.95, 0.99, 0.9, 0.5])
    response = np.array([4.0, -2.0j, -1.0 - 1.0j, 0.1])
    drawn = drawn_measurement(frequency, response, coherence, np.full(4, 0.1))
    card.measuring.keep("pitch", "actuator", screen.trial.judged_flown, drawn)
    magnitude, _ = card.bode.plots
    size = curve(magnitude, "measured")[1]
    np.testing.assert_allclose(size[:3], 20.0 * np.log10([4.0, 2.0, math.sqrt(2.0)]))
    assert math.isnan(size[3])
    spread = curve(magnitude, "measured +σ")[1] - size
    np.testing.assert_allclose(spread[:3], 20.0 * math.log10(1.1))
    card.choose_loop("roll")
    settle(lambda: shows(card, "flown"))
    assert "measured" not in magnitude.names


def synthetic(system, frequency):
    """A drawn loop of an open loop of python-control's, with its margins."""
    response = system(1j * frequency)
    gain, phase, _, _, crossover, _ = control.stability_margins(system)
    margins = LoopMargins(gain, 0.0, math.radians(phase), 0.1, 0.5, math.nan, math.nan, crossover)
    return DrawnLoop("flown", frequency, response, NOTHING, NOTHING, margins, NOTHING)


def test_margins_are_marked_where_python_control_has_them():
    """k / (s (s + 1) (s + 2)): its phase is -180 degrees at the root of 2, where |L| is k / 6."""
    s = control.tf("s")
    loop = synthetic(2.0 / (s * (s + 1) * (s + 2)), np.geomspace(0.05, 50.0, 250))
    frequency, value = gain_margin_mark(loop, 3.0)
    assert frequency == pytest.approx(math.sqrt(2.0), rel=1e-3)
    assert value == pytest.approx(-20.0 * math.log10(3.0), abs=0.02)
    frequency, value = phase_margin_mark(loop)
    assert frequency == pytest.approx(loop.margins.crossover, rel=1e-3)
    assert value + math.pi == pytest.approx(loop.margins.phase_margin, abs=1e-3)
    assert gain_margin_mark(loop, math.inf) is None
    _, top = peak(loop.frequency, loop.sensitivity)
    inverse = control.feedback(1, 2.0 / (s * (s + 1) * (s + 2)))
    assert top == pytest.approx(np.abs(inverse(1j * loop.frequency)).max())


def test_the_disk_touches_the_curve_whose_margin_it_is():
    """Its diameter goes from -(2 + a) / (2 - a) to -(2 - a) / (2 + a)."""
    x, _ = disk(1.0)
    assert (x.min(), x.max()) == (pytest.approx(-3.0), pytest.approx(-1.0 / 3.0, rel=1e-3))
    frequency = np.geomspace(0.05, 50.0, 2000)
    s = control.tf("s")
    response = (2.0 / (s * (s + 1) * (s + 2)))(1j * frequency)
    margin = (2.0 * np.abs(1.0 + response) / np.abs(1.0 - response)).min()
    x, y = disk(float(margin))
    middle, radius = 0.5 * (x.min() + x.max()), 0.5 * (x.max() - x.min())
    assert np.abs(response - middle).min() == pytest.approx(radius, rel=1e-3)
    assert np.hypot(x - middle, y).max() == pytest.approx(radius)


def test_curves_are_taken_as_they_were_answered():
    frequency, response = np.array([1.0, 2.0]), np.array([1.0j, 2.0])
    margins = synthetic(control.tf([1], [1, 1]) * 5.0, frequency).margins
    points = ("u", "error", "u", "1", "1")
    curves = GangOfFour(*points, frequency, response, response, response, margins)
    loop = drawn_curves("kept", curves)
    assert loop.at(1.0, loop.open_loop) == pytest.approx(1.0j)
    assert np.isnan(loop.at(3.0, loop.open_loop))
    assert abs(loop.at(math.sqrt(2.0), loop.open_loop)) == pytest.approx(math.sqrt(2.0))
    assert drawn_measurement(frequency, response, np.ones(2), np.zeros(2)).margins is None


def test_a_law_without_a_linear_model_is_said_to_have_none(screen, offline, qtbot):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Judge)))
    offline.analysis.refused.emit(offline.analysis.of(Judge)[-1], "betaflight-sitl is a program")
    assert screen.frequency.said.text() == "betaflight-sitl is a program"
