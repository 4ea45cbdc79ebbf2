"""The card of the map: a metric over two gains around the proposed ones."""

from PyQt6.QtCore import QTimer
from PyQt6.QtWidgets import QComboBox, QGridLayout, QWidget

from workbench.analysis.questions import DrawMap, Question
from workbench.analysis.replies import Mapped, Reply
from workbench.gui.number_field import buddy
from workbench.gui.tuning.card import SPACING, Card, Sentence
from workbench.gui.tuning.follower import Follower
from workbench.gui.tuning.limit_table import STEP_LIMITS
from workbench.gui.tuning.map_view import MapView
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace

PAIRS = {
    "x": ("kp_velocity_x", "kp_pitch"),
    "y": ("kp_velocity_y", "kp_roll"),
    "z": ("kp_velocity_z", "kd_velocity_z"),
    "yaw": ("kp_yaw_rate", "kd_pitch"),
}
"""Gains that a response along an axis depends on most."""
REST = 120
"""A map is asked for when gains have not moved for so long [ms]: it is a thousand flights."""


class MapCard(Card):
    """Follows the proposed gains; a click on the map proposes others.

    Args:
        workspace: analysis and colours.
        trial: what is tried.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, trial: Trial, parent: QWidget | None = None) -> None:
        super().__init__("Map", parent)
        self._trial = trial
        self._axis = ""
        self._follower = Follower(
            workspace.analysis, workspace.analysis.mapped, DrawMap, _answers, self
        )
        self.across, self.upwards, self.number = QComboBox(), QComboBox(), QComboBox()
        for row in STEP_LIMITS:
            self.number.addItem(row.label, row.name)
        self.number.setCurrentIndex(1)
        self.view = MapView(workspace.look)
        self.reading = Sentence()
        grid = QGridLayout()
        grid.setSpacing(SPACING)
        fields = (("&Metric", self.number), ("A&cross", self.across), ("&Up", self.upwards))
        for column, (text, box) in enumerate(fields):
            grid.addWidget(buddy(text, box), 0, column)
            grid.addWidget(box, 1, column)
            grid.setColumnStretch(column, 1)
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
            box.setMinimumWidth(78)
            box.activated.connect(self._ask)
        self.body.addLayout(grid)
        self.body.addWidget(self.view, 1)
        self.body.addWidget(self.reading)
        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(REST)
        self._rest.timeout.connect(self._ask)
        trial.changed.connect(self._follow)
        self._follower.answered.connect(self._show)
        self._follower.refused.connect(lambda said: self.said.say(said, "warning"))
        workspace.analysis.preparing.connect(self._say_preparing)
        self.view.picked.connect(self._propose)
        self.view.read.connect(self._read)
        self._read("")

    def begin(self) -> None:
        """Forget the map of another vehicle."""
        self._follower.forget()
        self.view.show_map(None)
        for box in (self.across, self.upwards):
            box.clear()
            for name in self._trial.names:
                box.addItem(self._trial.gains.words(name), name)
                box.setItemData(box.count() - 1, self._trial.gains.table.find(name).help, 3)
        self._axis = ""
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the map is seen."""
        self._follower.set_seen(seen)
        self._say_waiting()

    def _follow(self) -> None:
        step = self._trial.step
        if step is not None and step.axis != self._axis and self.across.count():
            self._axis = step.axis
            law = self._trial.gains.table.controller
            names = {law.gain_of(name): name for name in self._trial.names}
            for box, name in zip((self.across, self.upwards), PAIRS[step.axis], strict=True):
                box.setCurrentIndex(max(0, box.findData(names.get(name))))
        self._show_spot()
        self._rest.start()

    def _ask(self) -> None:
        step, gains = self._trial.step, self._trial.judged
        x, y = self.across.currentData(), self.upwards.currentData()
        if step is None:
            self.said.say("A chirp has no step to measure.")
        elif not gains or not x:
            self.said.say("Nothing flies yet.")
        elif x == y:
            self.said.say("Choose two gains that are not the same.", "warning")
        else:
            self.said.say("")
            self._follower.ask(DrawMap(gains, x, y, self.number.currentData(), step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._follower.is_waiting:
            self.said.say("Drawing …")

    def _say_preparing(self, said: str) -> None:
        if self._follower.is_waiting:
            self.said.say(f"Drawing … {said}")

    def _show(self, mapped: Mapped) -> None:
        self.view.show_map(mapped)
        self.said.say("" if not self._follower.is_waiting else "Drawing …")
        self._show_spot()

    def _show_spot(self) -> None:
        gains, mapped = self._trial.judged, self.view.mapped
        if mapped is not None and mapped.asked.x in gains and mapped.asked.y in gains:
            self.view.show_spot(gains[mapped.asked.x], gains[mapped.asked.y])

    def _propose(self, x: float, y: float) -> None:
        mapped = self.view.mapped
        if mapped is not None:
            values = {mapped.asked.x: _rounded(x), mapped.asked.y: _rounded(y)}
            self._trial.adopt(values, "a place on the map")

    def _read(self, said: str) -> None:
        self.reading.say(said or "Click to propose; hatched: lost")


def _rounded(value: float) -> float:
    """Return three significant digits: a map is no finer."""
    return float(f"{value:.3g}")


def _answers(question: Question, reply: Reply) -> bool:
    return isinstance(reply, Mapped) and reply.asked == question
