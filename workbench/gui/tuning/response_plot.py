"""The plot of a response: command, flown, predicted, and the last ones as ghosts."""

from collections.abc import Mapping

import numpy as np
from PyQt6.QtWidgets import QVBoxLayout, QWidget

from workbench.analysis.replies import Predicted
from workbench.gui.charts.curve import COMMAND, CurveStyle
from workbench.gui.charts.plot import StaticPlot
from workbench.gui.tuning.command_line import command_line
from workbench.gui.tuning.gains_text import gains_text
from workbench.gui.tuning.response_history import GHOSTS, Response, ResponseHistory
from workbench.gui.tuning.rounds import StepPart
from workbench.gui.tuning.trace import Trace
from workbench.gui.workspace import Workspace
from workbench.scenario.axes import find_axis
from workbench.scenario.excitation import Excitation

FLOWN, PREDICTED, FUTURE, ASKED = "flown", "predicted", "ahead", "command"
_NOTHING = np.empty(0)


class ResponsePlot(QWidget):
    """Curves over the time from the edge of a round on.

    Args:
        workspace: colours and units.

    Attributes:
        plot: where they are drawn.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self.plot = StaticPlot(workspace)
        self.plot.set_hint("Press Start: the response appears here")
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.plot)
        self._length = 0.0
        self._ghosts: tuple[Response, ...] = ()

    def show_plan(self, excitation: Excitation, history: ResponseHistory) -> None:
        """Show what is asked for: of the round that was flown last, else of the next one."""
        flown = history.round
        shown = excitation if flown is None else flown.excitation
        axis = find_axis(shown.axis)
        label = "yaw rate" if axis.place is None else f"velocity {axis.name}"
        self._length = shown.round_time
        self.plot.set_axes("time after the step s", label, axis.unit)
        self.plot.set_window(0.0, self._length)
        again = flown.again if flown is not None else False
        self.plot.set_curve(ASKED, *command_line(shown, again=again), CurveStyle.SOLID, COMMAND)

    def show_flown(self, trace: Trace | None) -> None:
        """Show what was flown so far."""
        if trace is None:
            self.plot.remove_curve(FLOWN)
        else:
            self.plot.set_curve(FLOWN, trace.time, trace.response, CurveStyle.SOLID, 0)

    def show_predicted(self, predicted: Predicted | None, part: StepPart | None) -> None:
        """Show what the proposed gains would make of a step in the round."""
        if predicted is None or part is None or predicted.lost:
            self.plot.remove_curve(PREDICTED)
            return
        time = predicted.time + part.begin
        self.plot.set_curve(PREDICTED, time, predicted.response + part.before, CurveStyle.DASHED, 1)

    def show_future(self, time: np.ndarray = _NOTHING, values: np.ndarray = _NOTHING) -> None:
        """Show how the flight would go on with the proposed gains; nothing takes it away."""
        if len(time):
            self.plot.set_curve(FUTURE, time, values, CurveStyle.FAINT, 1)
        else:
            self.plot.remove_curve(FUTURE)

    def show_ghosts(self, ghosts: tuple[Response, ...], gains: Mapping[str, float]) -> None:
        """Show the last responses; the tool tip of the legend says which gains made them.

        Args:
            ghosts: the newest first.
            gains: that fly now.
        """
        lines = []
        if len(ghosts) > len(self._ghosts):  # they lie below what is flown now
            for name in (FLOWN, PREDICTED, FUTURE):
                self.plot.remove_curve(name)
        for index in range(GHOSTS):
            name = ghost_name(index)
            if index >= len(ghosts):
                self.plot.remove_curve(name)
                continue
            each = ghosts[index]
            if each not in self._ghosts[index : index + 1]:
                trace = each.trace
                self.plot.set_curve(name, trace.time, trace.response, CurveStyle.FAINT, COMMAND)
            withheld = each.numbers.withheld if each.numbers is not None else ""
            note = f" ({withheld})" if withheld else ""
            lines.append(f"{name}: {gains_text(each.round.gains, gains)}{note}")
        self._ghosts = ghosts
        self.plot.legend.setToolTip("\n".join(lines))


def ghost_name(index: int) -> str:
    """Return the name of the response so many before the last."""
    return f"−{index + 1}"
