"""The form, driven by mouse and keyboard."""

import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QAbstractSpinBox, QLineEdit

from workbench.control.controller_file import load_controller
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_panel import GainPanel
from workbench.gui.gains.gain_rows import FILTERS_GROUP
from workbench.live.view import LiveView

NAME = "kp_velocity_x"
LEFT = Qt.MouseButton.LeftButton
SHIFT = Qt.KeyboardModifier.ShiftModifier
CONTROL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def panel(rig, workspace, qtbot):
    made = GainPanel(workspace, rig.editor)
    qtbot.addWidget(made)
    made.resize(380, 600)
    made.show()
    qtbot.waitExposed(made)
    return made


def filters(law):
    """Return the names of the filters beside the gains of a law."""
    return {row.name for system in ("gyro", "computer") for row in law.table.of(system)}


def retype(field, text):
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)


def shown(panel):
    return {name for name, row in panel.rows.items() if row.isVisible()}


def test_every_row_of_the_controller_has_a_line(panel):
    own = {row.name for row in load_controller().table.of("controller")}
    assert set(panel.rows) == own | filters(load_controller())


def test_limits_wait_behind_their_heading(panel):
    assert NAME in shown(panel)
    assert "max_tilt" not in shown(panel)
    heading = next(each.heading for each in panel._groups if each.heading.text() == "Limits")
    QTest.mouseClick(heading, LEFT)
    assert "max_tilt" in shown(panel)


def test_everything_else_that_is_live_can_be_set_too(rig, panel):
    QTest.mouseClick(panel._more.heading, LEFT)
    assert set(panel.rows) == {row.name for row in rig.editor.rows}
    panel.rows["wind_x"].field.setFocus()
    retype(panel.rows["wind_x"].field, "5")
    QTest.keyClick(panel.rows["wind_x"].field, Qt.Key.Key_Return)
    assert rig.flight.given == [("wind_x", 5.0)]


def test_another_controller_has_its_own_lines_in_its_own_groups(rig, panel, qtbot):
    pid = load_controller("pid")
    values = pid.table.defaults()
    rig.editor.begin(LiveView(values=values, vehicle=object(), controller=pid))
    qtbot.waitUntil(lambda: "ki_velocity_xy" in panel.rows)
    assert set(panel.rows) == {row.name for row in pid.parameters} | filters(pid)
    titles = [each.heading.text() for each in panel._groups if each.heading.text()]
    assert titles == ["Position", "Velocity", "Attitude", "Rate", "Yaw", "Limits", FILTERS_GROUP]
    retype(panel.rows["ki_velocity_xy"].field, "2.5")
    QTest.keyClick(panel.rows["ki_velocity_xy"].field, Qt.Key.Key_Return)
    assert rig.analysis.asked[-1].gains["ki_velocity_xy"] == 2.5
    rig.analysis.judge(stable=True)
    assert ("ki_velocity_xy", 2.5) in rig.flight.given


def test_units_change_as_another_flight_begins(rig, panel, new_view, workspace, qtbot):
    """The lines of the flight before stand until its own are made, with values that it has not."""
    QTest.mouseClick(panel._more.heading, LEFT)
    view = new_view()
    del view.values["wind_x"]
    rig.editor.begin(view)
    workspace.preferences.changed.emit("units")
    qtbot.waitUntil(lambda: panel._shown == rig.editor.rows)
    assert "wind_x" not in panel.rows


def test_all_gains_stand_without_scrolling(panel):
    assert panel._area.widget().height() <= panel._area.viewport().height()
    names = {
        row.name
        for row in load_controller().table.of("controller")
        if not row.name.startswith("max_")
    }
    assert shown(panel) == names


def test_a_typed_number_flies(rig, panel):
    rig.know()
    retype(panel.rows[NAME].field, "4.5")
    QTest.keyClick(panel.rows[NAME].field, Qt.Key.Key_Return)
    assert rig.flight.given == [(NAME, 4.5)]


def test_a_drag_flies_while_it_moves_and_is_one_step_of_undo(rig, panel):
    rig.know()
    slider = panel.rows[NAME].slider
    x = round(slider._x(slider._place))
    QTest.mousePress(slider, LEFT, pos=QPoint(x, 12))
    for way in (2, 4, 6):
        QTest.mouseMove(slider, QPoint(x + way, 12))
    QTest.mouseRelease(slider, LEFT, pos=QPoint(x + 6, 12))
    assert [name for name, _ in rig.flight.given] == [NAME, NAME, NAME]
    assert rig.editor.flown[NAME] > 3.0
    rig.editor.undo()
    assert rig.editor.flown[NAME] == 3.0


@pytest.mark.parametrize(
    ("key", "modifiers", "value"),
    [
        (Qt.Key.Key_Right, Qt.KeyboardModifier.NoModifier, 3.05),
        (Qt.Key.Key_Left, SHIFT, 2.75),
        (Qt.Key.Key_Up, CONTROL, 3.005),
    ],
)
def test_arrow_keys_step_finely_coarsely_and_finest(rig, panel, key, modifiers, value):
    rig.know()
    QTest.keyClick(panel.rows[NAME].slider, key, modifiers)
    assert rig.flight.given == [(NAME, value)]


def test_up_and_down_step_in_the_field(rig, panel):
    rig.know()
    field = panel.rows[NAME].field
    field.setFocus()
    QTest.keyClick(field, Qt.Key.Key_Up)
    QTest.keyClick(field, Qt.Key.Key_Down, SHIFT)
    assert [value for _, value in rig.flight.given] == [3.05, 2.8]


def test_a_value_out_of_range_is_marked_and_not_flown(rig, panel):
    rig.know()
    row = panel.rows[NAME]
    retype(row.field, "99")
    QTest.keyClick(row.field, Qt.Key.Key_Return)
    assert row.is_refused and "keep it within 0 .. 30" in rig.editor.faults[NAME]
    assert "keep it within 0 .. 30" in row.field.toolTip()
    assert rig.flight.given == []
    QTest.keyClick(row.field, Qt.Key.Key_Escape)
    assert not row.is_refused and not rig.editor.faults
    assert row.field.value() == 3.0


def test_what_is_no_number_cannot_be_typed(rig, panel):
    rig.know()
    retype(panel.rows[NAME].field, "nan")
    QTest.keyClick(panel.rows[NAME].field, Qt.Key.Key_Return)
    assert rig.flight.given == []
    assert rig.editor.proposed[NAME] == 3.0


def test_enter_applies_and_escape_puts_back_where_the_user_prefers_so(rig, panel, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.know()
    slider = panel.rows[NAME].slider
    slider.setFocus()
    QTest.keyClick(slider, Qt.Key.Key_Right)
    assert rig.flight.given == []
    assert panel.rows[NAME].mark.text() == "◇"
    QTest.keyClick(slider, Qt.Key.Key_Return)
    assert rig.flight.given == [(NAME, 3.05)]
    assert panel.rows[NAME].mark.text() == "◆"
    QTest.keyClick(slider, Qt.Key.Key_Right)
    QTest.keyClick(slider, Qt.Key.Key_Escape)
    assert rig.editor.proposed[NAME] == 3.05
    assert len(rig.flight.given) == 1


def test_the_reset_button_goes_back_to_the_start(rig, panel, qtbot):
    rig.know()
    row = panel.rows[NAME]
    assert not row.reset.isEnabled()
    rig.editor.propose(NAME, 5.0)
    rig.editor.keep()
    QTest.mouseClick(row.reset, LEFT)
    assert rig.editor.flown[NAME] == 3.0


def test_a_change_is_marked_by_shape_and_word(rig, panel, qtbot):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    mark = panel.rows[NAME].mark
    qtbot.waitUntil(lambda: mark.text() == "◆")
    assert mark.accessibleName() == "Velocity x Kp: tried, not kept; kept is 3\N{NO-BREAK SPACE}1/s"
    rig.editor.keep()
    qtbot.waitUntil(lambda: mark.text() == "")


def test_a_search_finds_by_word_in_every_group_and_gives_all_back(panel):
    before = shown(panel)
    panel.search.setFocus()
    QTest.keyClicks(panel.search, "tilt")
    assert shown(panel) == {"max_tilt"}
    QTest.keyClick(panel.search, Qt.Key.Key_Escape)
    assert shown(panel) == before
    QTest.keyClicks(panel.search, "wind x")
    assert shown(panel) == {"wind_x"}


def test_limits_are_shown_and_typed_in_degrees(rig, panel, workspace):
    row = panel.rows["max_tilt"]
    assert row.field.value() == pytest.approx(40.107, abs=1e-3)
    row._type(45.0)
    assert rig.flight.given == [("max_tilt", pytest.approx(0.785398, abs=1e-6))]
    row._type(95.0)
    said = "Max tilt is 95°: keep it within 2.865° to 68.75°"
    assert rig.editor.faults == {"max_tilt": said}
    workspace.preferences.set("angle_unit", "radian")
    assert row.field.suffix() == ""
    assert row._unit_shown.text() == "rad"


def test_leaving_a_field_untouched_changes_nothing(rig, panel):
    rig.flight.publish(2.0, kp_velocity_x=4.123456789)
    field = panel.rows[NAME].field
    field.setFocus()
    QTest.keyClick(field, Qt.Key.Key_Return)
    panel.search.setFocus()
    assert rig.flight.given == []
    assert rig.editor.proposed[NAME] == 4.123456789


def test_stable_ranges_reach_the_sliders(rig, panel):
    rig.know(kp_velocity_x=(1.0, 8.0))
    row = panel.rows[NAME]
    assert row.slider._stable == (row.slider.scale.place(1.0), row.slider.scale.place(8.0))
    assert row.slider._fresh
    assert "stable 1\N{NO-BREAK SPACE}1/s to 8\N{NO-BREAK SPACE}1/s" in row.slider.toolTip()
    rig.flight.publish(2.0, kp_velocity_y=4.0)
    assert not row.slider._fresh
    assert "with earlier gains" in row.slider.toolTip()


def test_linking_by_its_box_moves_both(rig, panel):
    rig.know()
    panel.linked.click()
    QTest.keyClick(panel.rows[NAME].slider, Qt.Key.Key_Right)
    assert panel.rows["kp_velocity_y"].field.value() == 3.05


def test_every_control_says_its_name_unit_and_range(panel):
    row = panel.rows[NAME]
    limits = "0\N{NO-BREAK SPACE}1/s to 30\N{NO-BREAK SPACE}1/s"
    assert row.slider.accessibleName() == f"Velocity x Kp slider, {limits}"
    assert row.field.accessibleName() == f"Velocity x Kp value, {limits}"
    assert row._name.buddy() is row.field
    assert "velocity P gain, x" in row.slider.toolTip()
    for part in panel.findChildren((QAbstractSpinBox, QLineEdit)):
        parent = part.parent()
        assert part.accessibleName() or isinstance(parent, QAbstractSpinBox)


def test_before_a_flight_it_says_so(workspace, rig, qtbot):
    editor = GainEditor(rig.flight, rig.analysis, workspace.preferences, workspace.notices)
    panel = GainPanel(workspace, editor)
    qtbot.addWidget(panel)
    panel.show()
    assert panel.nothing.isVisible()
    assert panel.rows == {}


def test_another_vehicle_gets_lines_of_its_own(rig, panel, new_view, qtbot):
    rig.editor.begin(new_view(kp_velocity_x=2.0))
    qtbot.waitUntil(lambda: panel.rows[NAME].field.value() == 2.0)
    assert panel.rows[NAME].slider._start == panel.rows[NAME].slider.scale.place(2.0)


def test_no_name_is_cut(panel):
    QTest.mouseClick(panel._more.heading, LEFT)
    cut = [
        name for name, row in panel.rows.items() if row._name.sizeHint().width() > row._name.width()
    ]
    assert cut == []


def test_what_happens_elsewhere_takes_nothing_from_who_types(rig, panel, qtbot):
    field = panel.rows[NAME].field
    retype(field, "4.")
    rig.flight.publish(2.0, kp_roll=170.0)
    qtbot.waitUntil(lambda: panel.rows["kp_roll"].field.value() == 170.0)
    qtbot.wait(20)
    assert field.text() == "4."


def test_the_parameters_own_name_stands_beside_its_label_where_there_is_room(panel, qapp):
    """One label a gain, and the name that files and commands use."""
    row = panel.rows["kp_velocity_x"]
    labels = {each._label.text for each in panel.rows.values()}
    assert len(labels) == len(panel.rows)
    for width, shown in ((560, True), (500, False)):  # below, the slider would be shorter
        panel.resize(width, 700)
        qapp.processEvents()
        assert row.own_name.isVisible() is shown
        assert row.own_name.text() == "kp_velocity_x"
