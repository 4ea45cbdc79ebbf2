"""The card of the map: a metric over two gains around the proposed ones."""

from itertools import zip_longest

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QComboBox

from workbench.analysis.queries import DrawMap, RequestedStep
from workbench.analysis.replies import Mapped
from workbench.control.controller import Controller
from workbench.design.tune.variables import loops_for
from workbench.gui.analysis import SETTLING_MS, QueryStream
from workbench.gui.errands import single_shot
from workbench.gui.labels import tip_text
from workbench.gui.layout import fill
from workbench.gui.tuning.card import ToneLabel, TuningCard, fields_beside, set_items
from workbench.gui.tuning.limits import STEP_LIMITS
from workbench.gui.tuning.map_view import MapView
from workbench.gui.tuning.trial import NO_TRIAL_STEP_TEXT, TuningTrial
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace

METRIC_LABELS = {row.name: row.label for row in STEP_LIMITS}


class MapCard(TuningCard):
    """Follows the proposed gains; a click on the map proposes others.

    Args:
        workspace: analysis and colours.
        trial: the gains that are being tried.
    """

    def __init__(self, workspace: Workspace, trial: TuningTrial) -> None:
        super().__init__("Map")
        self._trial = trial
        self._absence = workspace.absence
        self._axis = ""
        self._shown_step: RequestedStep | None = None
        self._queries = QueryStream(workspace.analysis, self)
        self.across, self.upwards, self.number = ComboBox(), ComboBox(), ComboBox()
        set_items(self.number, METRIC_LABELS)
        self.number.setCurrentIndex(1)
        self.view = MapView(workspace.look, trial.gains.words)
        self.reading = ToneLabel()
        fields = (("&Metric", self.number), ("A&cross", self.across), ("&Up", self.upwards))
        for _, box in fields:
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
            box.activated.connect(self._ask)
        fill(self.body, fields_beside(fields), (self.view, 1), self.reading)
        self._rest = single_shot(self._ask, self, SETTLING_MS)
        trial.changed.connect(self._follow)
        workspace.absence.changed.connect(lambda _: self._rest.start())
        self._queries.answered.connect(self._show)
        self._queries.refused.connect(self._show_refusal)
        self._queries.preparing.connect(lambda said: self.said.say(f"Drawing … {said}"))
        self.view.picked.connect(self._propose)
        self.view.read.connect(self._read)
        self._read("")

    def begin(self) -> None:
        """Clear the map of another vehicle."""
        self._queries.forget()
        self.view.show_map(None)
        for box in (self.across, self.upwards):
            box.clear()
            for name in self._trial.names:
                box.addItem(self._trial.gains.words(name), name)
                help = self._trial.gains.controller.table.find(name).help
                box.setItemData(box.count() - 1, tip_text(help), Qt.ItemDataRole.ToolTipRole)
        self._axis = ""
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._queries.set_seen(seen)
        self._say_waiting()

    def _follow(self) -> None:
        step = self._trial.step
        if step is not None and step.axis != self._axis and self.across.count():
            self._axis = step.axis
            law = self._trial.gains.controller
            names = {law.gain_of(name): name for name in self._trial.names}
            first = [names[gain] for gain in axis_gains(law, step.axis) if gain in names]
            pair = tuple(dict.fromkeys((*first, *self._trial.names)))
            for box, name in zip((self.across, self.upwards), pair, strict=False):
                box.setCurrentIndex(box.findData(name))
        self._show_spot()
        self._rest.start()

    def _ask(self) -> None:
        step, gains = self._trial.step, self._trial.judged
        x, y = self.across.currentData(), self.upwards.currentData()
        if step is None:
            self._queries.forget()  # an answer about an earlier step would pass for one about this
            self._clear_other_step()
            self.said.say(NO_TRIAL_STEP_TEXT)
        elif not gains or not x:
            self.said.say(self._absence.text or "Not known yet.")
        elif x == y:
            self._queries.forget()
            self._show_refusal("Choose two different gains.")
        else:
            self.said.say("")
            self._queries.ask(DrawMap(gains, x, y, self.number.currentData(), step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._queries.is_waiting:
            self.said.say("Drawing …")

    def _show(self, asked: DrawMap, mapped: Mapped) -> None:
        self._shown_step = asked.step
        self.view.show_map(mapped, (asked.x, asked.y), METRIC_LABELS[asked.metric])
        self.said.say("" if not self._queries.is_waiting else "Drawing …")
        self._show_spot()

    def _show_refusal(self, said: str) -> None:
        self._clear_other_step()
        self.said.say(said, "warning")

    def _clear_other_step(self) -> None:
        """Clear the map of another step, which would pass for one of this step."""
        if self._shown_step != self._trial.step:
            self.view.show_map(None)

    def _show_spot(self) -> None:
        gains, (x, y) = self._trial.judged, self.view.names
        if x in gains and y in gains:
            self.view.show_spot(gains[x], gains[y])

    def _propose(self, x: float, y: float) -> None:
        across, up = self.view.names
        values = {across: _round_for_map(x), up: _round_for_map(y)}
        self._trial.gains.adopt(values, "a place on the map")

    def _read(self, said: str) -> None:
        self.reading.say(said or "Click to propose; hatched: crashes")


def axis_gains(law: Controller, axis: str) -> list[str]:
    """Return the gains of the loops of an axis: the first of each loop, then the second ones."""
    rows = zip_longest(*(loop.gains for loop in loops_for(law, axis)))
    return [gain for row in rows for gain in row if gain is not None]


def _round_for_map(value: float) -> float:
    """Return three significant digits, enough for a map."""
    return float(f"{value:.3g}")
