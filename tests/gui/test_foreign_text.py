"""Text from outside in the app: shown as it is, nowhere as markup, bounded, and named nowhere else.

The first tests read the sources: a label, a tool tip or a rich text that is not made by the helpers
is found. The others give thirty hostile names to everything that the window shows.
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from PyQt6.QtCore import QModelIndex, Qt
from PyQt6.QtGui import QAction, QImage, QPainter, QTextDocument
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QComboBox,
    QGraphicsTextItem,
    QGraphicsView,
    QLabel,
    QLineEdit,
    QMessageBox,
    QPlainTextEdit,
    QTabBar,
    QTextEdit,
    QWidget,
)

import workbench.gui
from tests.hostile_names import LONGEST, NAMES, acting
from workbench.common.flight import Flight
from workbench.common.plain_text import plain_name, plain_text
from workbench.common.series import Series
from workbench.gui.arguments_dialog import ArgumentsDialog
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.legend import WORD_JOINER, Legend, LegendEntry
from workbench.gui.charts.number_axis import MAX_AXIS_NAME_CHARACTERS, NumberAxis
from workbench.gui.instruments.readout import Hint
from workbench.gui.labels import TIP_MARKUP, Label, WrappedName, set_tip, tip_text
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.tuning.card import ToneLabel
from workbench.gui.visualization.log_worker import short_series_name
from workbench.link.backplane import ClientStatus, ServerStatus
from workbench.link.messages import ControlOwner, ControlState, LinkLossStage, Role
from workbench.live.messages import NetworkView
from workbench.plant.formats.xacro import XacroArgument

GUI = Path(workbench.gui.__file__).parent
PLACES = {
    "labels.py": "QLabel setToolTip setTextFormat escape",
    "charts/legend.py": "QLabel setTextFormat RichText html_text",
    "charts/canvas.py": "setHtml html_text TextItem",
    "charts/number_axis.py": "setLabel html_text",
    "home/heading_tape.py": "PlotWidget",
    "home/lidar_card.py": "TextItem",
    "home/path_map.py": "TextItem",
    "instruments/plane_view.py": "PlotWidget TextItem setLabel html_text",
    "joystick/handling_panel.py": "TextItem",
    "tuning/map_view.py": "PlotWidget TextItem setLabel html_text",
    "tuning/nyquist_plot.py": "PlotWidget setLabel",
    "tuning/pole_plane.py": "PlotWidget setLabel",
    "tuning/weights_card.py": "PlotWidget TextItem",
    "visualization/cloud_view.py": "TextItem",
    "visualization/frames_page.py": "setToolTip",  # of a column's head
    "help.py": "QTextBrowser QTextDocument setMarkdown setWhatsThis html_text",
    "number_field.py": "setToolTip",
    "key_map.py": "escape",  # of a pattern
    "tuning/session_report.py": "html_text",
    "unsaved_question.py": "QMessageBox setTextFormat",
    "gains/gain_bar.py": "QInputDialog",
}
"""What each file may use of the names below, because it shows words of ours, or escapes others."""
WATCHED = {
    *("QLabel", "QMessageBox", "QErrorMessage", "QInputDialog", "QTextBrowser", "QTextDocument"),
    *("QStaticText", "QGraphicsTextItem", "QProgressDialog", "QSystemTrayIcon", "QWizard"),
    *("setTextFormat", "setToolTip", "setWhatsThis", "setHtml", "setMarkdown", "insertHtml"),
    *("toHtml", "setLabel", "TextItem", "LabelItem", "PlotWidget", "PlotItem", "LegendItem"),
    *("RichText", "MarkdownText", "AutoText", "html_text", "escape", "QToolTipLabel"),
}
"""Names that show text as markup, or may."""
GUARDED = {"setTabToolTip", "showText", "setItemData"}
"""Calls that take a tool tip as well, of which `tip_text` makes all but a constant."""


def uses(source: str) -> Iterator[str]:
    """Yield the watched names that a source uses, and the guarded calls without `tip_text`."""
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Attribute(attr=name) | ast.Name(id=name) if name in WATCHED:
                yield name
            case ast.alias(name=name) if name in WATCHED:
                yield name
            case ast.Call(func=ast.Attribute(attr=name), args=args) if name in GUARDED:
                if not any(_is_made(each) for each in args):
                    yield name


def _is_made(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value=str()) | ast.Call(func=ast.Name(id="tip_text")):
            return True
    return False


def test_labels_and_tool_tips_are_made_by_the_helpers(case):
    for path in sorted(GUI.rglob("*.py")):
        file = path.relative_to(GUI).as_posix()
        with case(file):
            assert set(uses(path.read_text())) <= set(PLACES.get(file, "").split())


def test_what_is_made_otherwise_is_found(case):
    for source, found in (
        ("from PyQt6.QtWidgets import QLabel", "QLabel"),
        ("made = QtWidgets.QLabel(name)", "QLabel"),
        ("self.setToolTip(name)", "setToolTip"),
        ("box.currentTextChanged.connect(box.setToolTip)", "setToolTip"),
        ("item = pg.TextItem(html=name)", "TextItem"),
        ("label.setTextFormat(Qt.TextFormat.AutoText)", "setTextFormat"),
        ("tabs.setTabToolTip(0, name)", "setTabToolTip"),
        ("QToolTip.showText(place, name)", "showText"),
        ("axis.setLabel(name)", "setLabel"),
    ):
        with case(source):
            assert found in set(uses(source))
    assert not set(uses("tabs.setTabToolTip(0, tip_text(name))\nset_tip(box, name)"))


TOP = QModelIndex()


def shown_texts(window: QWidget) -> Iterator[tuple[str, str]]:
    """Yield everything that a window and its parts show, with its place; markup comes as it is."""
    for each in (window, *window.findChildren(QWidget)):
        kind = type(each).__name__
        yield f"title of {kind}", each.windowTitle()
        yield f"tip of {kind}", each.toolTip()
        if isinstance(each, QLabel) and each.text() and not isinstance(each, Legend):
            assert each.textFormat() is Qt.TextFormat.PlainText, each.text()
            yield kind, each.text()
        if isinstance(each, QAbstractButton):
            yield kind, each.text()
        if isinstance(each, QLineEdit):
            yield f"placeholder of {kind}", each.placeholderText()
        if isinstance(each, QTextEdit | QPlainTextEdit):
            yield kind, each.toPlainText()
        if isinstance(each, QTabBar):
            for index in range(each.count()):
                yield kind, each.tabText(index)
                yield f"tip of {kind}", each.tabToolTip(index)
        if isinstance(each, QComboBox):
            yield from _cells(kind, each.model())
        if isinstance(each, QAbstractItemView):
            yield from _cells(kind, each.model())
        if isinstance(each, QGraphicsView) and each.scene() is not None:
            for item in each.scene().items():
                if isinstance(item, QGraphicsTextItem):
                    yield f"{type(item).__name__} in {kind}", item.toPlainText()
    for action in window.findChildren(QAction):
        yield "action", action.text()
        yield "tip of action", action.toolTip()


def _cells(kind: str, model, parent=TOP) -> Iterator[tuple[str, str]]:
    for row in range(model.rowCount(parent)):
        for column in range(model.columnCount(parent)):
            index = model.index(row, column, parent)
            yield f"cell of {kind}", str(index.data() or "")
            yield f"tip of {kind}", str(index.data(Qt.ItemDataRole.ToolTipRole) or "")
            yield from _cells(kind, model, index)


@pytest.fixture
def painted(monkeypatch):
    """Every text that our own widgets paint."""
    found, draw = [], QPainter.drawText

    def note(painter, *args):
        found.extend(("painted", each) for each in args if isinstance(each, str))
        return draw(painter, *args)

    monkeypatch.setattr(QPainter, "drawText", note)
    return found


def faults(texts) -> list[tuple[str, str]]:
    """Return the texts that act, are endless, or would be taken for markup by a tool tip."""
    return [
        (place, ascii(text[:100]))
        for place, text in texts
        if acting(text, f"\n\t{WORD_JOINER}")
        or len(text) > LONGEST
        or (
            place.startswith("tip") and Qt.mightBeRichText(text) and not text.startswith(TIP_MARKUP)
        )
    ]


VIEWS = count(1)


def view_of(view, names):
    """Return a view in which everything that comes from outside has one of some names."""
    vehicle = view.vehicle

    def name(place):
        return names[place % len(names)]

    rotors = tuple(
        replace(each, name=f"{name(index)}{index}") for index, each in enumerate(vehicle.rotors)
    )
    sensors = tuple(
        replace(each, name=f"{name(index)} {index}") for index, each in enumerate(vehicle.sensors)
    )
    clients = tuple(
        ClientStatus(peer, name(peer), name(peer + 1), "tcp", Role.COMMAND, 1.0, 0.1, 0, 0)
        for peer in range(1, 5)
    )
    control = ControlState(ControlOwner.CLIENT, 1, name(2), LinkLossStage.LIVE, 0.0, name(3))
    refusals = {"bad": 2 * next(VIEWS)}  # two more than in the last view
    log = (name(4), name(5))
    server = ServerStatus("127.0.0.1:7000", "http://127.0.0.1/", clients, refusals, log)
    topics = tuple(
        replace(each, about={**each.about, "frames": [[name(6), name(7)], [name(6), name(8)]]})
        if each.name.endswith("/frames")
        else each
        for each in view.topics
    )
    return replace(
        view,
        vehicle=replace(vehicle, name=name(0), rotors=rotors, sensors=sensors),
        scenario=replace(view.scenario, title=name(1)),
        controller=None,
        remarks=(name(9),),
        topics=topics,
        network=NetworkView(server, control, name(10)),
    )


def log_of(names):
    """Return a log whose signals and units have some names."""
    time = np.linspace(0.0, 3.0, 50)
    units = {}
    for name, other in zip(names, names[1:], strict=False):
        units[short_series_name(f"{name}.{other}", units)] = name
    file = names[0].replace("/", "_").replace("\0", "")[:200]
    signals = {name: Series(name, unit, time, np.sin(time)) for name, unit in units.items()}
    return Flight(names[1], Path("/tmp") / file, "", signals, remarks=(names[2],), end=3.0)


@pytest.fixture(scope="module")
def window(shared_window, shared_workspace):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shared_workspace.analysis, "warm_up", lambda: None)
        patch.setattr(shared_workspace.analysis, "ask", lambda question: None)
        yield shared_window


@pytest.fixture
def fly(window, shared_workspace, monkeypatch, qapp):
    """Show a view of a flight whose names are given, on all screens."""

    def show(view, names):
        view = view_of(view, names)
        flight = shared_workspace.flight
        monkeypatch.setattr(flight, "_view", view)
        flight.begun.emit(view)
        flight.viewed.emit(view)
        return view

    return show


def test_no_name_acts_anywhere_in_the_window(window, shared_workspace, fly, canned, qapp, painted):
    window.resize(1280, 720)
    found = []
    for first in range(0, len(NAMES), 5):
        names = NAMES[first:] + NAMES[:first]
        fly(canned.views[0], names)
        shared_workspace.notices.warn(names[0], names[1])
        shared_workspace.flight.opening.emit(names[2])
        screen = window.stack.screen_of("visualization")
        window.show_screen("visualization")
        screen._show_log(log_of(names))
        for name in [*screen.charts._source.units][:6]:
            screen.charts.board.add_signal(name)
        screen.charts.add_overlay(names[3], log_of(names))
        for row in SCREEN_TABLE:
            window.show_screen(row.name)
            qapp.processEvents()
            window.grab()
        found += faults(shown_texts(window))
        screen.close_log()
    assert painted
    found += faults(painted)
    assert sorted(set(found)) == []


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    """A picture of a size that no text has."""
    path = tmp_path_factory.mktemp("pictures") / "large.png"
    QImage(700, 600, QImage.Format.Format_RGB32).save(str(path))
    return path


@pytest.mark.parametrize("make", [Label, WrappedName, ToneLabel])
def test_a_label_opens_no_picture(qapp, picture, make):
    named, plain = make(), make()
    named.setText(f"<img src='{picture}'>")
    plain.setText(f"[img src='{picture}']")
    assert named.sizeHint().height() == plain.sizeHint().height() < 100
    late = make()
    late.setText(f"a <img src='{picture}'>")
    assert late.sizeHint().height() == plain.sizeHint().height()


def test_a_tool_tip_shows_what_it_is_given(qapp, case):
    for name in NAMES:
        with case(name[:60]):
            tip = tip_text(f"line one <b>\n{name}")
            page = QTextDocument()
            page.setHtml(tip) if Qt.mightBeRichText(tip) else page.setPlainText(tip)
            assert page.toPlainText() == plain_text(f"line one <b>\n{name}")
            box = QAction(tip)
            set_tip(box, name)
            assert Qt.mightBeRichText(box.toolTip()) is box.toolTip().startswith(TIP_MARKUP)


def test_a_legend_renders_its_own_tags_alone(shared_workspace, case):
    look = shared_workspace.look
    legend = Legend(look)
    for name in NAMES:
        with case(name[:60]):
            legend.set_title(name)
            colour = look.colour("accent")
            legend.show_entries(
                [LegendEntry(name, name, colour, CurveStyle.SOLID, 1, visible=True)]
            )
            assert set(re.findall(r"<([^/ >]+)", legend.text())) <= {"a", "b", "span"}
            assert acting(legend.text(), WORD_JOINER) == []
            page = QTextDocument()
            page.setHtml(legend.text())
            shown = page.toPlainText().replace(WORD_JOINER, "").replace("\N{NO-BREAK SPACE}", " ")
            assert shown.count(plain_name(name)) == 3


def test_the_name_of_an_axis_is_text(qapp, case):
    axis = NumberAxis("left")
    for name in NAMES:
        with case(name[:60]):
            axis.show_name(name)
            assert (
                axis.label.toPlainText().split()
                == plain_name(name, MAX_AXIS_NAME_CHARACTERS).split()
            )


def test_a_hint_in_place_of_an_instrument_is_bounded(shared_workspace, case):
    hint = Hint("Lidar")
    for name in NAMES:
        with case(name[:60]):
            hint.say(name, f"{name} has no lidar in its description.")
            assert faults(list(shown_texts(hint))) == []


def test_no_name_widens_the_window(window, fly, canned, qapp):
    """What needs no room with a plain name needs none with a long one either."""

    def widths(names):
        fly(canned.views[0], names)
        for row in SCREEN_TABLE:
            window.show_screen(row.name)
            qapp.processEvents()
        found = [window.minimumSizeHint().width()]
        return found + [
            window.stack.screen_of(row.name).minimumSizeHint().width() for row in SCREEN_TABLE
        ]

    plain = widths(("plain",))
    for name in NAMES:
        if len(name) > 60:
            assert widths((name,)) == plain, name[:60]
            assert window.top_bar.strip.link.minimumSizeHint().width() < window.width()


def test_dialogs_show_names_as_they_are(window, shared_workspace, monkeypatch, qapp, case):
    for name in NAMES:
        with case(name[:60]):
            needed = (XacroArgument(name, None), XacroArgument(f"{name} more", name[:50]))
            dialog = ArgumentsDialog(name, needed, print, window)
            assert faults(shown_texts(dialog)) == []
            assert dialog.minimumSizeHint().width() < 1000
            dialog.close()
            screen = window.stack.current
            monkeypatch.setattr(type(screen), "unsaved", lambda screen, name=name: name)
            window._ask_to_save(print)
            texts = dict.fromkeys(text for _, text in shown_texts(window.findChild(QMessageBox)))
            assert plain_text(name) in texts
            window.findChild(QMessageBox).close()
            qapp.processEvents()
