"""The card that compares designs: kept, flown, proposed, slots, and other controllers."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QAction, QContextMenuEvent
from PyQt6.QtWidgets import (
    QMenu,
    QStackedWidget,
)

from workbench.analysis.replies import JudgedLoop
from workbench.design.metrics import find_metric
from workbench.gui.charts.curve import COMMAND, CurveStyle
from workbench.gui.charts.legend import Entry, Legend
from workbench.gui.charts.plots import StaticPlot
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import clipboard
from workbench.gui.flight_control import FlightControl
from workbench.gui.gains.gain_editor import SLOTS
from workbench.gui.labels import menu_text, set_tip
from workbench.gui.layout import choice, hbox, menu_button, scroll_area
from workbench.gui.tuning.card import SPACING, Card, offer
from workbench.gui.tuning.designs import FLOWN, KEPT, PROPOSED, Design, DesignAnswers, Designs
from workbench.gui.tuning.drawn_loop import decibel, unwrapped
from workbench.gui.tuning.limits import MARGIN_LIMITS, STEP_LIMITS, Limit, Limits
from workbench.gui.tuning.loop_plots import BodePlots, keep
from workbench.gui.tuning.margins_card import LimitOf, loop_label, short_label, weakest_loop
from workbench.gui.tuning.number_table import BEST, Cell, NumberTable, Row
from workbench.gui.tuning.poles_card import Pole, PolePlane
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace
from workbench.scenario.axes import find_axis

DASH = "–"
WEAKEST = "weakest"
STEP, FREQUENCY, POLES, TABLE = "Step", "Frequency", "Poles", "Table"
VIEWS = (STEP, FREQUENCY, POLES, TABLE)
COMMANDED = "command"
HIGH = 250
"""Least height at which the phase is below the magnitude [px]."""


@dataclass(frozen=True)
class Compared:
    """A row of the table: one number for each design.

    Attributes:
        name: name as on the command line, as overshoot or pitch.phase_margin.
        label: name on the screen.
        limit: its format and its limit.
        values: values of the designs in SI; NaN if a design has none.
        help: explanation of each value.
    """

    name: str
    label: str
    limit: Limit
    values: tuple[float, ...]
    help: tuple[str, ...]

    @property
    def best(self) -> int | None:
        """Index of the best value; None with fewer than two values, or if two look alike."""
        shown = [self.limit.shown(value) for value in self.values]
        known = [value for value in shown if not math.isnan(value)]
        if len(known) < 2:
            return None
        best = max(known) if self.limit.at_least else min(known)
        alike = [self.limit.digits(value) == self.limit.digits(best) for value in shown]
        return alike.index(True) if alike.count(True) == 1 else None

    def row(self, most: float) -> Row:
        """Return it as a row of a table; `most` is its limit as shown."""
        cells = []
        for place, (value, help) in enumerate(zip(self.values, self.help, strict=True)):
            over = not math.isnan(value) and not self.limit.keeps(value, most)
            marked = BEST if place == self.best else ""
            cells.append(Cell(self.limit.text(value), over=over, help=help, marked=marked))
        return Row(self.label, tuple(cells))


def compared_rows(designs: Sequence[Design], loop: str, limit_of: LimitOf) -> tuple[Compared, ...]:
    """Return the numbers of designs: of the step, of each one's weakest loop, and of one loop.

    Args:
        designs: one column each.
        loop: name of the selected loop.
        limit_of: returns a limit by name, as shown; these determine the weakest loop.
    """
    weakest = [
        weakest_loop(each.judged, limit_of) if each.judged is not None else None for each in designs
    ]
    chosen = [each.loop(loop) for each in designs]
    return (
        *(_of_step(limit, designs) for limit in STEP_LIMITS),
        *(_of_loop(WEAKEST, limit, designs, weakest) for limit in MARGIN_LIMITS),
        *(_of_loop(loop, limit, designs, chosen) for limit in MARGIN_LIMITS),
    )


def table_rows(
    compared: Sequence[Compared], designs: Sequence[Design], loop: str, limit_of: LimitOf
) -> tuple[Row, ...]:
    """Return the rows of the table, with a line that names the loop above its margins.

    Args:
        compared: result of `compared_rows`.
        designs: one column each.
        loop: name of the selected loop.
        limit_of: returns a limit by name, as shown.
    """
    rows = [each.row(limit_of(each.limit.name)) for each in compared]
    cells = []
    for each in designs:
        weakest = weakest_loop(each.judged, limit_of) if each.judged is not None else None
        name = short_label(weakest.name) if weakest is not None else DASH
        help = f"{each.name}: {_why(each) or 'the loop that is nearest to its limits'}"
        if each.judged is not None and not each.judged.stable:
            name, help = "unstable", f"{each.name}: {each.judged.said}"
        cells.append(Cell(name, over=name == "unstable", help=help))
    first, second = len(STEP_LIMITS), len(STEP_LIMITS) + len(MARGIN_LIMITS)
    rows.insert(second, Row(f"Loop {loop_label(loop)}", (Cell(""),) * len(designs), strong=True))
    rows.insert(first, Row("Weakest loop", tuple(cells), strong=True))
    return tuple(rows)


def csv_text(compared: Sequence[Compared], designs: Sequence[Design]) -> str:
    """Return the numbers as CSV in SI: one per line, with names and units of the command line."""
    lines = [",".join(["metric", "unit", *(each.name for each in designs)])]
    for row in compared:
        unit = find_metric(row.limit.name).unit
        values = ["" if math.isnan(value) else f"{value:.9g}" for value in row.values]
        lines.append(",".join([row.name, unit, *values]))
    return "\n".join(lines) + "\n"


def plain_text(rows: Sequence[Row], designs: Sequence[Design]) -> str:
    """Return the table as shown, in columns; a star marks the best value of a row."""
    lines = [["", *(f"{each.name} " for each in designs)]]
    for row in rows:
        lines.append([row.label, *(c.text + ("*" if c.marked else " ") for c in row.cells)])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = ""
    for name, *numbers in lines:
        padded = [each.rjust(width) for each, width in zip(numbers, widths[1:], strict=True)]
        text += "  ".join([name.ljust(widths[0]), *padded]).rstrip() + "\n"
    return text


def _of_step(limit: Limit, designs: Sequence[Design]) -> Compared:
    values, help = [], []
    for each in designs:
        numbers = each.predicted.numbers if each.predicted is not None else None
        lost = each.predicted is not None and each.predicted.lost
        value = getattr(numbers, limit.name) if numbers is not None and not lost else math.nan
        why = f"{limit.label}, {limit.help}"
        if math.isnan(value):
            withheld = numbers.withheld if numbers is not None else _why(each)
            why = "the drone would be lost" if lost else withheld or why
        values.append(value)
        help.append(f"{each.name}: {why}")
    return Compared(limit.name, _label(limit), limit, tuple(values), tuple(help))


def _of_loop(
    name: str, limit: Limit, designs: Sequence[Design], loops: Sequence[JudgedLoop | None]
) -> Compared:
    values, help = [], []
    for each, loop in zip(designs, loops, strict=True):
        value = getattr(loop, limit.name) if loop is not None and loop.stable else math.nan
        if loop is None:
            why = _why(each) or f"it has no loop {loop_label(name)}"
        elif loop.stable:
            why = f"{loop_label(loop.name)}: {limit.label.lower()}, {limit.help}"
        else:
            why = each.judged.said if each.judged is not None else ""
        values.append(value)
        help.append(f"{each.name}: {why}")
    label = f"   {limit.short} {limit.unit}".rstrip()
    return Compared(f"{name}.{limit.name}", label, limit, tuple(values), tuple(help))


def _label(limit: Limit) -> str:
    return f"{limit.label} {limit.unit}"


def _why(design: Design) -> str:
    """Return why nothing is known of a design, "" if it is known."""
    return design.said or ("not known yet" if design.judged is None else "")


class CompareCard(Card):
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
        self, workspace: Workspace, trial: Trial, designs: Designs, limits: Limits
    ) -> None:
        super().__init__("Compare")
        self._look, self._notices = workspace.look, workspace.notices
        self._trial, self._designs, self._limits = trial, designs, limits
        self._control = FlightControl(workspace.flight, workspace.preferences, self)
        self._answers = DesignAnswers(workspace.analysis, self)
        self._hidden: set[str] = set()
        self._added: set[str] = set()
        self._keeping: Mapping[str, float] | None = None
        self._compared: tuple[Compared, ...] = ()
        self._preparing = ""
        self._seen = False
        self.view = choice("What is shown", VIEWS, "What is shown of the designs")
        self.loop = choice("Loop", help="The loop whose frequency curves and margins are shown")
        self.choose = menu_button("&Designs", "Choose what is compared", self._fill_choose)
        self.use = menu_button("&Use", "Fly or keep one, or copy the table", self._fill_use)
        self.legend = Legend(workspace.look)
        self.plot = StaticPlot(workspace)
        self.bode = BodePlots(workspace, HIGH)
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
            plot.canvas.hovered.connect(lambda _: self._show_legend())
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
        elif design.name == KEPT:
            gains.revert()
        elif design.name == PROPOSED:
            gains.apply()
        else:
            gains.adopt(self._designs.gains_of(design.name), f"slot {design.name}")

    def keep(self, design: Design) -> None:
        """Keep the gains of a design; gains that do not fly yet are first evaluated and flown."""
        if design.name == FLOWN:
            self._trial.gains.keep()
            return
        self._keeping = self._designs.gains_of(design.name)
        self.fly(design)
        self._go_on_keeping()

    def copy_text(self) -> None:
        """Copy the table as shown."""
        known = self._known()
        self._copy(plain_text(self._rows(known), known))

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
        drawn = self.view.currentText() == FREQUENCY
        self._answers.follow(self.chosen, self._trial.step, self._loop if drawn else "")
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
        self._compared = compared_rows(designs, self._loop, self._limits.value)
        views: dict[str, Callable[[Sequence[Design]], None]] = {
            STEP: self._show_steps,
            FREQUENCY: self._show_frequency,
            POLES: self._show_poles,
            TABLE: self._show_table,
        }
        views[self.view.currentText()](designs)
        self._show_legend()
        self.said.say(*self._sentence())

    def _show_legend(self) -> None:
        drawn = {each.label: each for each in self._drawn_entries()}
        entries, lines = [], []
        for each in self._listed():
            visible = self._is_chosen(each)
            colour = self._look.curve(each.colour)
            shown = drawn.get(each.name)
            number, value = (shown.number, shown.value) if shown is not None else (0, "")
            label = f"{each.name} ({each.short})" if each.short else each.name
            entries.append(Entry(label, value, colour, each.style, number, visible))
            lines.append("\n    ".join((each.name, *each.long)))
        self.legend.show_entries(entries)
        set_tip(self.legend, "\n".join(lines))
        self.legend.setAccessibleDescription("; ".join(lines))

    def _drawn_entries(self) -> tuple[Entry, ...]:
        """Return the legend of the shown chart: its numbers, and values at the cursor."""
        shown = {STEP: self.plot, FREQUENCY: self.magnitude}.get(self.view.currentText())
        return shown.legend.entries if shown is not None else ()

    def _listed(self) -> tuple[Design, ...]:
        """Return the entries of the legend: all sets, and the selected controllers."""
        return tuple(
            each for each in self._designs.all() if not each.controller or self._is_chosen(each)
        )

    def _show_steps(self, designs: Sequence[Design]) -> None:
        step = self._trial.step
        found = {
            each.name: (each.predicted.time, each.predicted.response, each.style, each.colour)
            for each in designs
            if each.predicted is not None and not each.predicted.lost
        }
        for name in self.plot.names:
            if step is None or name not in (*found, COMMANDED):
                self.plot.remove_curve(name)
        if step is None:
            self.plot.set_hint("A chirp has no step to be compared")
            return
        axis = find_axis(step.axis)
        label = "yaw rate" if axis.place is None else f"velocity {axis.name}"
        self.plot.set_hint("Not known yet: the analyst is computing it")
        self.plot.set_axes("time after the step", label, axis.unit)
        self.plot.set_window(0.0, step.duration)
        asked = np.array([step.amplitude, step.amplitude])
        self.plot.set_curve(
            COMMANDED, np.array([0.0, step.duration]), asked, CurveStyle.SOLID, COMMAND
        )
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
            self.magnitude.set_curve(design.name, frequency, decibel(loop), *stroke)
            phase = unwrapped(frequency, loop, known.margins.crossover)
            self.phase.set_curve(design.name, frequency, phase, *stroke)
        for plot in self.bode.plots:
            keep(plot, names)

    def _show_poles(self, designs: Sequence[Design]) -> None:
        poles = []
        for each in designs:
            for value in each.judged.poles if each.judged is not None else ():
                if value.imag >= -1e-9:
                    filled = each.style is CurveStyle.DASHED
                    poles.append(Pole(complex(value), filled, each.name, each.colour))
        self.plane.show_poles(poles)

    def _rows(self, known: Sequence[Design]) -> tuple[Row, ...]:
        """Return the rows of the table."""
        limit_of = self._limits.value
        return table_rows(compared_rows(known, self._loop, limit_of), known, self._loop, limit_of)

    def _show_table(self, known: Sequence[Design]) -> None:
        rows = self._rows(known)
        self.table.set_head([each.name for each in known], ["\n".join(d.long) for d in self.chosen])
        self.table.expect(len(rows))
        self.table.set_rows(rows)
        self.table.setMinimumWidth(self.table.full_width)

    def _offer_loops(self, designs: Sequence[Design]) -> None:
        """Offer the loops of all designs; at first select the weakest one of the proposed gains."""
        found: dict[str, None] = {}
        weakest = ""
        for each in sorted(designs, key=lambda design: design.name != PROPOSED):
            if each.judged is not None:
                found |= dict.fromkeys(loop.name for loop in each.judged.loops)
                loop = weakest_loop(each.judged, self._limits.value)
                weakest = weakest or (loop.name if loop is not None else "")
        texts = {name: loop_label(name) for name in found}
        if found and offer(self.loop, texts, weakest):
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
        best = [designs[row.best].name for row in self._compared if row.best is not None]
        counts = {name: best.count(name) for name in dict.fromkeys(best)}
        if not counts:
            return "None is better than another." if len(designs) > 1 else "", "muted"
        ordered = sorted(counts.items(), key=lambda each: -each[1])
        said = ", ".join(f"{name} in {count}" for name, count in ordered)
        return f"{BEST.capitalize()}: {said} of {len(self._compared)} rows.", "muted"

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
            action = _action(menu, menu_text(each.name), partial(self.choose_design, each))
            action.setCheckable(True)
            action.setChecked(self._is_chosen(each))
            set_tip(action, "\n".join(each.long))
        for slot in SLOTS:
            if slot not in self._trial.gains.slots:
                _action(menu, f"{slot}: empty", lambda _: None).setEnabled(False)

    def _fill_use(self, menu: QMenu) -> None:
        for each in self.chosen:
            self._add_uses(menu, each)
        menu.addSeparator()
        self._add_copies(menu)

    def _add_uses(self, menu: QMenu, design: Design) -> None:
        """Add actions for a design."""
        gains_of = self._designs.gains_of
        if design.name != FLOWN:
            fly = _action(menu, f"Fly {menu_text(design.name)}", lambda _: self.fly(design))
            same = not design.controller and gains_of(design.name) == gains_of(FLOWN)
            fly.setEnabled(not same)
        if design.name != KEPT and not design.controller:
            keep = _action(menu, f"Keep {menu_text(design.name)}", lambda _: self.keep(design))
            keep.setEnabled(gains_of(design.name) != gains_of(KEPT))

    def _add_copies(self, menu: QMenu) -> None:
        _action(menu, "Copy table as &text", lambda _: self.copy_text())
        _action(menu, "Copy table as &CSV, in SI units", lambda _: self.copy_csv())

    def _copy(self, text: str) -> None:
        clipboard().setText(text)
        self._notices.inform("The table is on the clipboard.")

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Offer actions for the column under the pointer, or for the table."""
        assert event is not None
        if self.view.currentText() != TABLE:
            return
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        column = self.table.column_at(self.table.mapFromGlobal(event.globalPos()).x())
        if 0 <= column < len(self.chosen):
            self._add_uses(menu, self.chosen[column])
            menu.addSeparator()
        self._add_copies(menu)
        menu.popup(event.globalPos())

    def _lay_out(self) -> None:
        self.legend.setAccessibleName("Designs, and what differs from the kept gains")
        self.plot.show_head(False)  # the card has the legend
        self.magnitude.set_axes("frequency", "|L|", "dB", "rad/s")
        self.phase.set_axes("frequency", "∠L", "rad", "rad/s")
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
            spacing=SPACING // 2,  # fits beside gains and response
        )
        self.body.addLayout(line)
        self.body.addWidget(self.legend)
        self.body.addWidget(self.stack, 1)


def _action(menu: QMenu, text: str, act: Callable[[bool], object]) -> QAction:
    """Add an action to a menu."""
    action = QAction(text, menu)
    action.triggered.connect(act)
    menu.addAction(action)
    return action
