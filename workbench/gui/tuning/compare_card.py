"""The card that compares designs: kept, flown, proposed, slots, and other controllers."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QContextMenuEvent
from PyQt6.QtWidgets import QMenu, QStackedWidget

from workbench.control.loop import loop_label
from workbench.design.judge.loop_response import decibels
from workbench.gui.charts.curve import COMMAND_COLOUR, CurveStyle
from workbench.gui.charts.legend import Legend, LegendEntry
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import clipboard
from workbench.gui.flight_control import FlightControl
from workbench.gui.gains.gain_actions import GAIN_SLOTS
from workbench.gui.labels import menu_text, set_tip
from workbench.gui.layout import add_action, choice, fill, hbox, menu_button, scroll_area
from workbench.gui.tuning.bode_plots import BodePlots
from workbench.gui.tuning.card import CARD_SPACING_PX, TuningCard, set_items
from workbench.gui.tuning.comparison import (
    ComparedNumber,
    best_text,
    compared_loops,
    compared_rows,
    comparison_text,
    csv_text,
    table_rows,
)
from workbench.gui.tuning.design_answers import DesignAnswers
from workbench.gui.tuning.designs import FLOWN_SET, KEPT_SET, PROPOSED_SET, Design, Designs
from workbench.gui.tuning.drawn_loop import unwrapped_phase
from workbench.gui.tuning.frequency_plots import keep_curves
from workbench.gui.tuning.limits import LimitValues
from workbench.gui.tuning.number_row import NumberRow
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.tuning.pole import Pole, poles_of
from workbench.gui.tuning.pole_plane import PolePlane
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.workspace import Workspace
from workbench.scenario.loads import find_excited

STEP_VIEW, FREQUENCY_VIEW, POLES_VIEW, TABLE_VIEW = "Step", "Frequency", "Poles", "Table"
COMPARISON_VIEWS = (STEP_VIEW, FREQUENCY_VIEW, POLES_VIEW, TABLE_VIEW)
COMPARED_COMMAND_CURVE = "command"
LEGEND_VALUES_TEXT = "Values at the pointer; of a step, else at its end"
NO_STEP_TEXT = "Choose a step of a setpoint or an attitude, not a chirp or a load."


class CompareCard(TuningCard):
    """Compares designs: step responses, poles, and a table of numbers.

    The step is that of the excitation, from hover. The legend shows the differences from the kept
    gains; a click there hides a design, and the menu selects designs.

    Args:
        workspace: flight, analysis and colours.
        trial: the gains that are being tried, and the step.
        designs: the existing designs.
        limits: limits of the numbers.

    Attributes:
        view: the shown results.
        loop: loop whose margins are in the table.
    """

    def __init__(
        self, workspace: Workspace, trial: TuningTrial, designs: Designs, limits: LimitValues
    ) -> None:
        super().__init__("Compare")
        self._look, self._notices = workspace.look, workspace.notices
        self._trial, self._designs, self._limits = trial, designs, limits
        self._control = FlightControl(workspace.flight, workspace.preferences, self)
        self._answers = DesignAnswers(workspace.analysis, self)
        self._hidden: set[str] = set()
        self._added: set[str] = set()
        self._keeping: Mapping[str, float] | None = None
        self._compared: tuple[ComparedNumber, ...] = ()
        self._preparing = ""
        self._seen = False
        self.view = choice("What is shown", COMPARISON_VIEWS, "What is shown of the designs")
        self.loop = choice("Loop", help="The loop whose frequency curves and margins are shown")
        self.choose = menu_button("&Designs", "Choose what is compared", self._fill_choose)
        self.use = menu_button("&Use", "Fly or keep one, or copy the table", self._fill_use)
        self.legend = Legend(workspace.look)
        self.plot = StaticPlot(workspace, shows_end=True)
        self.bode = BodePlots(workspace)
        self.magnitude, self.phase = self.bode.plots
        self.plane = PolePlane(workspace.look)
        self.table = NumberTable(
            "Numbers of each design", (), workspace.look, paired=False, widest="", worded=False
        )
        self._lay_out()
        self._soon = single_shot(self._show, self)
        self.view.currentIndexChanged.connect(self._follow)
        self.loop.currentIndexChanged.connect(self._follow)
        self.legend.toggled.connect(self._toggle_entry)
        for plot in (self.plot, self.magnitude):
            plot.legend.entries_changed.connect(self._show_legend)
        self.plane.read.connect(self._read)
        self._answers.changed.connect(self._soon.start)
        designs.changed.connect(self._follow)
        trial.changed.connect(self._follow)
        trial.gains.state_changed.connect(self._go_on_keeping)
        limits.changed.connect(lambda _: self._soon.start())
        workspace.look.changed.connect(self._soon.start)
        workspace.analysis.preparing.connect(self._say_preparing)
        self._follow()

    @property
    def chosen(self) -> tuple[Design, ...]:
        """The compared designs."""
        return tuple(each for each in self._designs.all() if self._is_chosen(each))

    def begin(self) -> None:
        """Clear the answers about another flight, or another controller."""
        self._keeping = None
        self._answers.clear()
        self.loop.clear()
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask and draw only while the card is visible."""
        self._seen = seen
        self._answers.set_seen(seen)
        self._follow()

    def choose_design(self, design: Design, chosen: bool) -> None:
        """Add a design to the comparison, or remove it."""
        if design.controller:
            (self._added.add if chosen else self._added.discard)(design.controller)
        else:
            (self._hidden.discard if chosen else self._hidden.add)(design.name)
        self._follow()

    def fly(self, design: Design) -> None:
        """Fly a design from now on."""
        gains = self._trial.gains
        if design.controller:
            self._control.fly_controller(design.controller)
        elif design.name == KEPT_SET:
            gains.revert()
        elif design.name == PROPOSED_SET:
            gains.apply()
        else:
            gains.adopt(self._designs.gains_of(design.name), f"slot {design.name}")

    def keep(self, design: Design) -> None:
        """Keep the gains of a design; gains that do not fly yet are first evaluated and flown."""
        if design.name == FLOWN_SET:
            self._trial.gains.keep()
            return
        self._keeping = self._designs.gains_of(design.name)
        self.fly(design)
        self._go_on_keeping()

    def copy_text(self) -> None:
        """Copy the table as shown."""
        known = self._known()
        self._copy(comparison_text(self._rows(known), known))

    def copy_csv(self) -> None:
        """Copy the numbers, in SI."""
        known = self._known()
        self._copy(csv_text(compared_rows(known, self._loop, self._limits.value), known))

    def _go_on_keeping(self) -> None:
        """Keep the requested gains once they fly; give up if other gains are proposed."""
        gains = self._trial.gains
        if self._keeping is None:
            return
        if gains.proposed_gains != self._keeping:
            self._keeping = None
        elif not gains.unflown:
            self._keeping = None
            gains.keep()

    def _is_chosen(self, design: Design) -> bool:
        if design.controller:
            return design.controller in self._added
        return design.name not in self._hidden

    def _follow(self) -> None:
        """Ask about the selected designs."""
        if not self._seen:  # while another card is open, a moving slider has the time
            return
        drawn = self.view.currentText() == FREQUENCY_VIEW
        self._answers.follow(self.chosen, self._trial.setpoint_step, self._loop if drawn else "")
        self._soon.start()

    @property
    def _loop(self) -> str:
        """Name of the selected loop, "" before one is known."""
        return self.loop.currentData() or ""

    def _known(self) -> tuple[Design, ...]:
        """Return the compared designs with their known results."""
        return tuple(map(self._answers.known, self.chosen))

    def _show(self) -> None:
        """Show the known results."""
        if not self._seen:
            return
        designs = self._known()
        self._offer_loops(designs)
        self.stack.setCurrentIndex(self.view.currentIndex())
        self.loop.setVisible(self.view.currentText() in (FREQUENCY_VIEW, TABLE_VIEW))
        self._compared = compared_rows(designs, self._loop, self._limits.value)
        views: dict[str, Callable[[Sequence[Design]], None]] = {
            STEP_VIEW: self._show_steps,
            FREQUENCY_VIEW: self._show_frequency,
            POLES_VIEW: self._show_poles,
            TABLE_VIEW: self._show_table,
        }
        views[self.view.currentText()](designs)
        self._show_legend()
        self.said.say(*self._sentence())

    def _show_legend(self) -> None:
        chart = {STEP_VIEW: self.plot, FREQUENCY_VIEW: self.magnitude}.get(self.view.currentText())
        drawn = {each.label: each for each in chart.legend.entries} if chart is not None else {}
        entries, lines = [], []
        for each in self._listed():
            visible = self._is_chosen(each)
            colour = self._look.curve(each.colour)
            shown = drawn.get(each.name)
            number, value = (shown.number, shown.value) if shown is not None else (0, "")
            entries.append(LegendEntry(each.label, value, colour, each.style, number, visible))
            lines.append("\n    ".join((each.name, *each.long)))
        self.legend.show_entries(entries)
        set_tip(self.legend, "\n".join((LEGEND_VALUES_TEXT, *lines)))
        self.legend.setAccessibleDescription("; ".join(lines))

    def _listed(self) -> tuple[Design, ...]:
        """Return the entries of the legend: all sets, and the selected controllers."""
        return tuple(
            each for each in self._designs.all() if not each.controller or self._is_chosen(each)
        )

    def _show_steps(self, designs: Sequence[Design]) -> None:
        step = self._trial.setpoint_step
        found = {
            each.name: (each.predicted.time, each.predicted.response, each.style, each.colour)
            for each in designs
            if each.predicted is not None and not each.predicted.lost
        }
        for name in self.plot.names:
            if step is None or name not in (*found, COMPARED_COMMAND_CURVE):
                self.plot.remove_curve(name)
        if step is None:
            self.plot.set_hint(NO_STEP_TEXT)
            return
        axis = find_excited(step.axis)
        self.plot.set_hint("Not known yet: the analyst is computing it")
        self.plot.set_axes("time after the step", axis.response, axis.response_unit)
        self.plot.set_window(0.0, step.duration)
        time = np.array([0.0, 0.0, step.duration])
        asked = np.array([0.0, step.amplitude, step.amplitude])
        self.plot.set_curve(COMPARED_COMMAND_CURVE, time, asked, CurveStyle.SOLID, COMMAND_COLOUR)
        for name, curve in found.items():
            self.plot.set_curve(name, *curve)

    def _show_frequency(self, designs: Sequence[Design]) -> None:
        """Show the open loop L of each design, as a Bode plot."""
        names = []
        for design in designs:
            if (known := design.curves) is None:
                continue
            names.append(design.name)
            frequency, loop = known.frequency, known.open_loop
            stroke = design.style, design.colour
            self.magnitude.set_curve(design.name, frequency, decibels(loop), *stroke)
            phase = np.degrees(unwrapped_phase(frequency, loop))
            self.phase.set_curve(design.name, frequency, phase, *stroke)
        for plot in self.bode.plots:
            keep_curves(plot, names)

    def _show_poles(self, designs: Sequence[Design]) -> None:
        poles: list[Pole] = []
        for each in designs:
            filled = each.style is CurveStyle.DASHED
            poles += poles_of(each.judged, proposed=filled, whose=each.name, colour=each.colour)
        self.plane.show_poles(poles)

    def _rows(self, known: Sequence[Design]) -> tuple[NumberRow, ...]:
        """Return the rows of the table."""
        return table_rows(known, self._loop, self._limits.value)

    def _show_table(self, known: Sequence[Design]) -> None:
        rows = self._rows(known)
        self.table.set_head([each.name for each in known], ["\n".join(d.long) for d in self.chosen])
        self.table.expect(len(rows))
        self.table.set_rows(rows)

    def _offer_loops(self, designs: Sequence[Design]) -> None:
        """Offer the loops of all designs; at first select one with another gain than kept, or else
        the weakest one of the proposed gains.
        """
        proposed_first = sorted(designs, key=lambda design: design.name != PROPOSED_SET)
        found, weakest = compared_loops(proposed_first, self._limits.value)
        texts = {name: loop_label(name) for name in found}
        moved = next((name for name in found if self._trial.is_moved(name)), weakest)
        if found and set_items(self.loop, texts, moved):
            self._follow()

    def _sentence(self) -> tuple[str, str]:
        """Return how complete the answers are, or which design is best in most rows."""
        designs = self._known()
        reasons = [f"{each.name}: {each.said}" for each in designs if each.said]
        if reasons:
            return "; ".join(reasons), "warning"
        missing = self._answers.missing
        if missing:
            what = self._preparing if any(each.controller for each in missing) else ""
            names = ", ".join(each.name for each in missing)
            return f"Computing {names} … {what}".rstrip(), "muted"
        return best_text(self._compared, designs), "muted"

    def _read(self, said: str) -> None:
        self.said.say(*((said, "muted") if said else self._sentence()))

    def _say_preparing(self, said: str) -> None:
        self._preparing = said
        if self._answers.missing:
            self.said.say(*self._sentence())

    def _toggle_entry(self, index: int) -> None:
        listed = self._listed()
        if index < len(listed):
            self.choose_design(listed[index], not self._is_chosen(listed[index]))

    def _fill_choose(self, menu: QMenu) -> None:
        for each in self._designs.all():
            choose = partial(self.choose_design, each)
            action = add_action(menu, menu_text(each.name), choose, self._is_chosen(each))
            set_tip(action, "\n".join(each.long))
        for slot in GAIN_SLOTS:
            if slot not in self._trial.gains.slots:
                add_action(menu, f"{slot}: empty", lambda _: None).setEnabled(False)

    def _fill_use(self, menu: QMenu) -> None:
        for each in self.chosen:
            self._add_uses(menu, each)
        menu.addSeparator()
        self._add_copies(menu)

    def _add_uses(self, menu: QMenu, design: Design) -> None:
        """Add actions for a design."""
        gains_of = self._designs.gains_of
        if design.name != FLOWN_SET:
            fly = add_action(menu, f"Fly {menu_text(design.name)}", lambda _: self.fly(design))
            same = not design.controller and gains_of(design.name) == gains_of(FLOWN_SET)
            fly.setEnabled(not same)
        if design.name != KEPT_SET and not design.controller:
            keep = add_action(menu, f"Keep {menu_text(design.name)}", lambda _: self.keep(design))
            keep.setEnabled(gains_of(design.name) != gains_of(KEPT_SET))

    def _add_copies(self, menu: QMenu) -> None:
        add_action(menu, "Copy table as &text", lambda _: self.copy_text())
        add_action(menu, "Copy table as &CSV, in SI units", lambda _: self.copy_csv())

    def _copy(self, text: str) -> None:
        clipboard().setText(text)
        self._notices.inform("The table is on the clipboard.")

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Offer actions for the column under the pointer, or for the table."""
        assert event is not None
        if self.view.currentText() != TABLE_VIEW:
            return
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        column = self.table.columnAt(self.table.mapFromGlobal(event.globalPos()).x()) - 1
        if 0 <= column < len(self.chosen):
            self._add_uses(menu, self.chosen[column])
            menu.addSeparator()
        self._add_copies(menu)
        menu.popup(event.globalPos())

    def _lay_out(self) -> None:
        self.legend.setAccessibleName("Designs, and what differs from the kept gains")
        self.plot.show_head(False)  # the card has the legend
        self.magnitude.set_axes("frequency", "|L|", "dB", "rad/s")
        self.phase.set_axes("frequency", "∠L", "°", "rad/s")
        self.stack = QStackedWidget()
        for part in (self.plot, self.bode, self.plane, scroll_area(self.table)):
            self.stack.addWidget(part)
        for each in (self.choose, self.use):
            each.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        line = hbox(
            (self.view, 1),
            (self.loop, 1),
            self.choose,
            self.use,
            spacing=CARD_SPACING_PX // 2,  # fits beside gains and response
        )
        fill(self.body, line, self.legend, (self.stack, 1))
