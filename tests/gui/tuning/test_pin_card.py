import shlex
from pathlib import Path

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QGuiApplication

from workbench.analysis.queries import RegressionCase, RequestedStep
from workbench.gui.tuning.pin_card import PinCard, name_fault, regress_command, spec_path

STEP = RequestedStep("x", 1.0, 2.0)


@pytest.fixture
def card(offline, trial, qtbot, tmp_path):
    trial.set_step(STEP)
    made = PinCard(offline, trial)
    qtbot.addWidget(made)
    made.folder.setText(str(tmp_path))
    made.show()
    return made


def press(qtbot, button):
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def test_what_flies_is_pinned_with_the_step(card, offline, trial, qtbot, tmp_path):
    card.name.selectAll()
    qtbot.keyClicks(card.name, "quick x")
    press(qtbot, card.button)
    path = tmp_path / "quick-x.workbench.yaml"
    assert offline.analysis.of(RegressionCase) == [
        RegressionCase(path, trial.flown, STEP, margins=True)
    ]


def test_paths_and_the_command_are_shown_and_copied(card, offline, qtbot, tmp_path):
    press(qtbot, card.button)
    spec = tmp_path / "my-step.workbench.yaml"
    pinned = spec, tmp_path / "my-step.baseline", "Holds a step."
    offline.analysis.tell(offline.analysis.of(RegressionCase)[-1], pinned)
    assert card.paths.text() == f"my-step.workbench.yaml and my-step.baseline in {tmp_path}"
    assert str(spec) in card.paths.toolTip()
    assert card.command.text() == f"workbench regress {spec}"
    press(qtbot, card.copy)
    assert QGuiApplication.clipboard().text() == f"workbench regress {spec}"


def test_overwriting_takes_a_second_press(card, offline, qtbot, tmp_path):
    (tmp_path / "my-step.workbench.yaml").write_text("mine")
    press(qtbot, card.button)
    assert offline.analysis.of(RegressionCase) == []
    assert card.said.text() == "my-step.workbench.yaml exists: press again to overwrite it."
    press(qtbot, card.button)
    assert len(offline.analysis.of(RegressionCase)) == 1


def test_another_name_is_asked_about_anew(card, offline, qtbot, tmp_path):
    (tmp_path / "my-step.workbench.yaml").write_text("mine")
    press(qtbot, card.button)
    card.name.setText("other")
    card.name.setText("my-step")
    press(qtbot, card.button)
    assert offline.analysis.of(RegressionCase) == []


def test_a_refusal_is_told_beside_the_button(card, offline, qtbot):
    press(qtbot, card.button)
    offline.analysis.refused.emit(offline.analysis.of(RegressionCase)[0], "the disk is full")
    assert card.said.text() == "the disk is full"
    assert card.button.isEnabled()


@pytest.mark.parametrize(("name", "good"), [("a b-1.x", True), ("", False), ("../x", False)])
def test_a_name_is_no_path(name, good):
    assert (name_fault(name) == "") is good


def test_a_command_can_be_pasted_into_a_shell():
    assert regress_command(Path("/a/b.workbench.yaml")) == "workbench regress /a/b.workbench.yaml"
    command = regress_command(Path("/a b/it's.yaml"))
    assert shlex.split(command) == ["workbench", "regress", "/a b/it's.yaml"]


def test_a_suffix_that_is_typed_is_not_doubled():
    assert spec_path("/a", "x.workbench.yaml") == Path("/a/x.workbench.yaml")


def test_a_load_can_be_pinned(card, offline, trial, qtbot):
    trial.set_step(RequestedStep("gust_x", 6.0, 4.0, acts=1.0))
    assert "gust x, east for 4 s" in card.what.text()
    press(qtbot, card.button)
    assert offline.analysis.of(RegressionCase)[-1].step == trial.excited
