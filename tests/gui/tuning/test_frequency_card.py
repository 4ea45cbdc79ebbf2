"""One loop over frequency: the card's curves against python-control's, its numbers the table's."""

import math
from functools import partial

import control
import numpy as np
import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtTest import QTest

from workbench.analysis.queries import DrawFrequency, Judge
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.margins import LoopMargins
from workbench.design.linear.linearize import linearize
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.drawn_loop import (
    DrawnLoop,
    drawn_curves,
    drawn_measurement,
    gain_margin_mark,
    phase_beside,
    phase_margin_mark,
    response_peak,
    unwrapped_phase,
)
from workbench.gui.tuning.nyquist_plot import disk_edge

NOTHING = np.empty(0)


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
        assert f"gain\N{NO-BREAK SPACE}+ {rise.text}\N{NO-BREAK SPACE}dB" in caption(magnitude)
        assert f"gain\N{NO-BREAK SPACE}− {fall.text}\N{NO-BREAK SPACE}dB" in caption(magnitude)
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
        assert card.nyquist.caption == f"disk {disk_margin.text}"
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

    def click(row):
        at = table.visualItemRect(table.item(row, 0)).center()
        QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)

    click(names.index("yaw rate"))
    assert card.curves.loop == "yaw_rate"
    settle(lambda: shows(card, "flown"))
    assert asked_about(offline, card, "flown").loop == "yaw_rate"
    click(len(names) - 1)  # the plant's input is no loop
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


def test_what_is_behind_another_tab_or_view_is_drawn_once_it_comes_to_the_front(screen, settle):
    card, poles = screen.frequency, screen.poles
    settle(lambda: shows(card, "flown"))
    assert poles.plane.poles == () and card.phase.table.rows == ()
    screen.tabs.setCurrentWidget(poles)
    first = poles.plane.poles
    assert first
    screen.tabs.setCurrentWidget(card)
    screen.gains.propose("kp_roll", 1.2 * screen.gains.proposed["kp_roll"])
    wanted = screen.gains.proposed["kp_roll"]
    settle(lambda: screen.judgement.gains["kp_roll"] == wanted)
    assert poles.plane.poles == first and card.phase.table.rows == ()
    screen.tabs.setCurrentWidget(poles)
    assert {each.proposed for each in poles.plane.poles} == {True, False}
    screen.tabs.setCurrentWidget(card)
    card.show_view("Phase")
    labels = [each.label for each in screen.margins.table.rows]
    assert [each.label for each in card.phase.table.rows] == labels[:-1]  # no plant's input


def test_the_same_curves_are_drawn_once(screen, settle, monkeypatch):
    card, drawn = screen.frequency, []
    settle(lambda: shows(card, "flown"))
    monkeypatch.setattr(card.bode, "show_loops", lambda loops: drawn.append([*loops]))
    for _ in range(3):
        screen.gains.state_changed.emit()
        card.curves.changed.emit()
    assert drawn == []
    screen.gains.propose("kp_roll", 1.2 * screen.gains.proposed["kp_roll"])
    settle(lambda: shows(card, "flown", "proposed"))
    assert len(drawn) == 1
    screen.workspace.look.changed.emit()  # other colours
    assert len(drawn) == 2


def test_an_unstable_loop_is_drawn_without_margins(screen, settle, offline):
    card = screen.frequency
    settle(lambda: shows(card, "flown"))
    card.choose_loop("pitch")
    screen.gains.propose("kd_pitch", 1.0)
    screen.gains.propose("kp_pitch", 900.0)
    settle(lambda: _is_of(offline, card, "proposed", 900.0))
    assert card.said.text() == "The closed loop is unstable with these gains."
    screen.judgement.note_vehicle("Of another vehicle.")
    assert card.said.text() == "The closed loop is unstable with these gains. Of another vehicle."
    assert card.said.property("class") == "bad"
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
    said = f"L at 20\N{NO-BREAK SPACE}rad/s:  {size:.1f} dB {turn:.1f}°".replace("-", "−")
    assert card.reading.text() == said
    assert [plot.cursor_time for plot in card.bode.plots] == [20.0, 20.0]
    card.show_view("Nyquist")
    (point,) = card.nyquist.dots
    assert point == pytest.approx(response, rel=1e-3)
    card.nyquist.point(response + 0.001)
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


def across(plot):
    """Return the ends of the shown frequencies, and where they are in the picture [px]."""
    box = plot.canvas.view.sceneBoundingRect()
    return *plot.window_ends, box.left(), box.right()


def test_a_measured_loop_is_drawn_where_it_is_coherent(screen, settle, qtbot):
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
    assert next(each.style for each in magnitude.curves if each.label == "measured") is (
        CurveStyle.POINTS
    )
    assert card.bode.coherence.isVisibleTo(card.bode)
    np.testing.assert_allclose(curve(card.bode.coherence, "measured")[1], coherence)
    qtbot.waitUntil(lambda: across(card.bode.coherence) == across(magnitude))
    spread = curve(magnitude, "measured +σ")[1] - size
    np.testing.assert_allclose(spread[:3], 20.0 * math.log10(1.1))
    card.choose_loop("roll")
    settle(lambda: shows(card, "flown"))
    assert "measured" not in magnitude.names
    assert not card.bode.coherence.isVisibleTo(card.bode)


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
    _, top = response_peak(loop.frequency, loop.sensitivity)
    inverse = control.feedback(1, 2.0 / (s * (s + 1) * (s + 2)))
    assert top == pytest.approx(np.abs(inverse(1j * loop.frequency)).max())


@pytest.mark.parametrize("gain", [0.02, 1.0, 30.0, 1000.0])
@pytest.mark.parametrize("integrators", [0, 1, 2, 3, 4])
def test_the_phase_begins_at_that_of_its_integrators_whatever_the_gain(gain, integrators):
    """k / (s^n (s + 3)^2) begins at -90 n degrees and ends 180 degrees below."""
    frequency = np.geomspace(1e-3, 1e3, 400)
    s = 1j * frequency
    phase = np.degrees(unwrapped_phase(frequency, gain / (s**integrators * (s + 3.0) ** 2)))
    assert phase[[0, -1]] == pytest.approx(
        [-90.0 * integrators, -90.0 * integrators - 180.0], abs=1
    )


def test_the_phase_margin_of_an_unstable_vehicle_is_read_from_minus_180_degrees():
    """3e5 (s + 2)^3 / ((s^2 - 0.2 s + 1) (s + 40)^4): L(0) is positive, a turn below 0 degrees.

    By hand: the unstable pair turns the phase by +180 degrees, and the zeros by +270, of which lags
    at 40 rad/s take a part below the crossover.
    """
    s = control.tf("s")
    unstable = 3e5 * (s + 2) ** 3 / ((s**2 - 0.2 * s + 1) * (s + 40) ** 4)
    loop = synthetic(unstable, np.geomspace(0.05, 500.0, 900))
    phase = unwrapped_phase(loop.frequency, loop.open_loop)
    at = np.interp(loop.margins.crossover, loop.frequency, phase)
    assert at + math.pi == pytest.approx(loop.margins.phase_margin, abs=2e-3)
    assert phase[0] == pytest.approx(-math.tau, abs=0.1)


def test_a_measurement_is_on_the_branch_of_its_model():
    """Three integrators and a lag end at -360 degrees: measured there alone, it is not at 0."""
    frequency = np.geomspace(0.01, 100.0, 200)
    s = 1j * frequency
    response = 1.0 / (s**3 * (s + 1.0))
    model = DrawnLoop("flown", frequency, response, NOTHING, NOTHING, None, NOTHING)
    measured = drawn_measurement(frequency[150:], response[150:], np.ones(50), np.zeros(50))
    np.testing.assert_allclose(phase_beside(measured, model), phase_beside(model, model)[150:])
    assert math.degrees(phase_beside(measured, model)[-1]) == pytest.approx(-360.0, abs=1.0)


def test_the_disk_touches_the_curve_whose_margin_it_is():
    """Its diameter goes from -(2 + a) / (2 - a) to -(2 - a) / (2 + a)."""
    x, _ = disk_edge(1.0)
    assert (x.min(), x.max()) == (pytest.approx(-3.0), pytest.approx(-1.0 / 3.0, rel=1e-3))
    frequency = np.geomspace(0.05, 50.0, 2000)
    s = control.tf("s")
    response = (2.0 / (s * (s + 1) * (s + 2)))(1j * frequency)
    margin = (2.0 * np.abs(1.0 + response) / np.abs(1.0 - response)).min()
    x, y = disk_edge(float(margin))
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
