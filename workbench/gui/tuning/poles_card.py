"""The card of poles: with the flown gains, and with the proposed ones, which can be dragged."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QPointF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QColor,
    QKeyEvent,
    QMouseEvent,
    QWheelEvent,
)

from workbench.analysis.questions import MovePole
from workbench.analysis.replies import PoleMoved
from workbench.gui.analysis import Follower
from workbench.gui.charts.ticks import round_step
from workbench.gui.labels import set_tip
from workbench.gui.layout import choice, fill
from workbench.gui.theme import Look
from workbench.gui.tuning.card import Card, Sentence, offer
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.margins_card import loop_label
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace

DAMPINGS = (0.2, 0.4, 0.6, 0.8)
RIGHT = 0.14
"""Share of the width to the right of the imaginary axis."""
SIZE = 4.5
"""Half the size of a pole [px]."""
EDGE = 14.0
"""Least distance of an unstable pole from the edge of the picture [px]."""
MOVED = 0.02
"""Step of a pole per key, as a share of its magnitude."""
ARROWS = {
    Qt.Key.Key_Left: -1.0,
    Qt.Key.Key_Right: 1.0,
    Qt.Key.Key_Up: 1.0j,
    Qt.Key.Key_Down: -1.0j,
}
"""Directions of the arrow keys."""
SHIFT = Qt.KeyboardModifier.ShiftModifier
HINT = "● proposed, to be dragged   ○ flown   ✕ unstable"
NEAR = 14.0
"""Largest distance from the pointer at which a pole is read [px]."""
FAR = 1e6
"""Right end of the marked unstable half of the plane [1/s]."""
SPANS = (2.0, 2000.0)
"""Smallest and largest visible distance to the left [1/s]."""

HALF_TURN = np.append(np.exp(1j * np.linspace(0.0, np.pi, 120)), np.nan)


Spot = dict[str, object]
"""A mark in the plane, as pyqtgraph takes it."""


@dataclass(frozen=True)
class Pole:
    """One pole of the closed loop.

    Attributes:
        value: its value [1/s].
        proposed: whether it belongs to the proposed gains, else to the flown ones, or to `whose`.
        whose: name of its design, if several are compared.
        colour: number of that design's colour.
    """

    value: complex
    proposed: bool
    whose: str = ""
    colour: int = 0

    @property
    def frequency(self) -> float:
        """Natural frequency [rad/s]."""
        return abs(self.value)

    @property
    def damping(self) -> float:
        """Damping ratio; negative if unstable."""
        return -self.value.real / abs(self.value) if self.value else 1.0

    @property
    def is_stable(self) -> bool:
        """Whether it decays."""
        return self.value.real < 0.0

    @property
    def text(self) -> str:
        """The pole in words."""
        whose = self.whose or ("proposed" if self.proposed else "flown")
        word = "" if self.is_stable else ", unstable"
        hertz = self.frequency / (2.0 * math.pi)
        where = f"{self.frequency:.3g} rad/s ({hertz:.3g} Hz)"
        return f"{whose}: {where}, damping {self.damping:.2f}{word}".replace("-", "−")


def shown_poles(flown: np.ndarray | None, proposed: np.ndarray | None) -> tuple[Pole, ...]:
    """Return the poles for both sets of gains, upper half of the plane; the flown ones first."""
    found = []
    for values, is_proposed in ((flown, False), (proposed, True)):
        if values is not None:
            found += [Pole(complex(each), is_proposed) for each in values if each.imag >= -1e-9]
    return tuple(found)


def poles_headline(proposed: np.ndarray) -> str:
    """Return a summary of the poles, as a sentence."""
    growing = int(np.count_nonzero(proposed.real >= 0.0))
    if growing:
        return f"{growing} unstable pole{'s' if growing > 1 else ''}."
    swinging = [Pole(complex(each), True) for each in proposed if abs(each.imag) > 1e-9]
    if not swinging:
        return "Nothing oscillates."
    least = min(swinging, key=lambda pole: pole.damping)
    return f"Least damping {least.damping:.2f}, at {least.frequency:.3g} rad/s."


class PolePlane(pg.PlotWidget):
    """Shows poles: hollow ones are flown, filled ones are proposed, crosses are unstable.

    An unstable pole outside the picture is at its edge, with an arrow towards its position.

    Args:
        look: source of colours.

    Attributes:
        span: visible distance to the left [1/s].
        poles: the shown poles.
    """

    read = pyqtSignal(str)
    """The pole under the pointer in words, "" for none."""
    taken = pyqtSignal(object)
    """A proposed `Pole` that is about to be moved, if poles can be moved."""
    wanted = pyqtSignal(object)
    """Requested place of the pole [1/s]."""
    released = pyqtSignal()
    """The pole is released."""
    given_up = pyqtSignal()
    """The pole returns to its original place."""

    def __init__(self, look: Look) -> None:
        super().__init__(enableMenu=False)
        self._look = look
        self.poles: tuple[Pole, ...] = ()
        self.span = 40.0
        self._chosen: Pole | None = None
        self._movable = False
        self._place: complex | None = None
        self._view = self.getViewBox()
        self._unstable = pg.LinearRegionItem((0.0, FAR), movable=False, pen=pg.mkPen(None))
        self._axis = pg.InfiniteLine(0.0)
        self._dampings = [
            pg.InfiniteLine(
                (0.0, 0.0),
                math.degrees(math.acos(-each)),
                label=f"{each:g}",
                labelOpts={"position": 0.95},
            )
            for each in DAMPINGS
        ]
        self._rings = pg.PlotCurveItem(antialias=True, connect="finite")
        self._spots = pg.ScatterPlotItem()
        for item in (self._unstable, self._axis, *self._dampings, self._rings, self._spots):
            self.addItem(item)
        self.hideButtons()
        self.hideAxis("left")
        self.plotItem.setContentsMargins(4.0, 4.0, 4.0, 0.0)
        self.setMinimumHeight(110)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Pole plane: left and right go from pole to pole, + and − zoom")
        self._view.sigResized.connect(self._fit)
        look.changed.connect(self._dress)
        self._dress()

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(320, 220)

    def show_poles(self, poles: Sequence[Pole]) -> None:
        """Show poles."""
        if tuple(poles) == self.poles:
            return
        self.poles = tuple(poles)
        if self._place is None and self._chosen not in self.poles:
            self._choose(None)
        self._show()

    def set_movable(self, movable: bool) -> None:
        """Set whether proposed poles can be moved: by the mouse, or by Shift and the arrow keys."""
        self._movable = movable
        if movable:
            self.setAccessibleName(
                "Pole plane: left and right go from pole to pole, with Shift the arrows move a "
                "proposed pole, + and − zoom"
            )

    def follow_pole(self, value: complex) -> None:
        """Read the proposed pole nearest to a value [1/s]: the one that is being moved."""
        proposed = [pole for pole in self.poles if pole.proposed]
        if proposed:
            self._choose(min(proposed, key=lambda pole: abs(pole.value - value)))

    def zoom(self, factor: float) -> None:
        """Zoom out by a factor, or in if it is below 1."""
        self.span = min(max(self.span * factor, SPANS[0]), SPANS[1])
        self._fit()

    def place(self, pole: Pole) -> QPointF:
        """Return a pole's position in the widget; an unstable one never leaves the picture."""
        return self._view.mapViewToScene(self._seen(pole))

    def is_beyond(self, pole: Pole) -> bool:
        """Return whether a pole is farther out than its position shows."""
        return self._seen(pole) != QPointF(pole.value.real, pole.value.imag)

    def _seen(self, pole: Pole) -> QPointF:
        """Return where in the plane a pole is drawn."""
        x, y = pole.value.real, pole.value.imag
        if pole.is_stable:
            return QPointF(x, y)
        (_, right), (_, top) = self._view.viewRange()
        edge = EDGE * self._view.viewPixelSize()[0]
        return QPointF(min(x, right - edge), min(y, top - edge))

    def _fit(self) -> None:
        """Show the span, with one scale along both axes: angles show the damping."""
        right = self.span * RIGHT / (1.0 - RIGHT)
        high = (self.span + right) * self._view.height() / max(self._view.width(), 1.0)
        self.setRange(xRange=(-self.span, right), yRange=(0.0, high), padding=0.0)
        step, reach = round_step(self.span, 4), math.hypot(self.span, high)
        rings = step * np.arange(1.0, reach / step)
        x, y = np.outer(rings, HALF_TURN.real), np.outer(rings, HALF_TURN.imag)
        self._rings.setData(x.ravel(), y.ravel())
        ticks = [(-ring, f"−{ring:g}") for ring in rings]
        self.getAxis("bottom").setTicks([[*ticks, (0.5 * right, "1/s")]])
        self._show()

    def _dress(self) -> None:
        """Apply the colours of the look."""
        colour = self._look.colour
        self.setBackground(colour("card"))
        self._view.setBackgroundColor(colour("field"))
        unstable = colour("bad")
        unstable.setAlpha(22)
        self._unstable.setBrush(unstable)
        self._axis.setPen(colour("muted"))
        self._rings.setPen(colour("line"))
        for line in self._dampings:
            line.setPen(colour("line"))
            line.label.setColor(colour("muted"))
        bottom = self.getAxis("bottom")
        bottom.setStyle(tickLength=0, tickFont=self.font())
        bottom.setPen(colour("muted"))
        bottom.setTextPen(colour("muted"))
        self._show()

    def _show(self) -> None:
        """Draw the poles."""
        spots = []
        for pole in self.poles:
            colour = self._look.colour("accent" if pole.proposed else "muted")
            if not pole.is_stable:
                colour = self._look.colour("bad")
            if pole.whose:
                colour = self._look.curve(pole.colour)
            at, fill = self._seen(pole), colour if pole.proposed else None
            if pole.is_stable:
                size = 1.5 * SIZE if pole.proposed else 2.0 * SIZE + 2.0
                spots.append(_spot(at, "o", size, colour, fill))
            else:
                spots.append(_spot(at, "x", 2.8 * SIZE, colour, fill))
            if self.is_beyond(pole):
                spots.append(self._arrow(pole, at, colour))
            if pole == self._chosen:
                spots.append(_spot(at, "o", 4.4 * SIZE, self._look.colour("ink")))
        if self._place is not None:
            at = QPointF(self._place.real, self._place.imag)
            spots.append(_spot(at, "crosshair", 4.4 * SIZE, self._look.colour("ink")))
        self._spots.setData(spots=spots)

    def _arrow(self, pole: Pole, at: QPointF, colour: QColor) -> Spot:
        """Return an arrow towards a pole outside the picture."""
        way = (EDGE - 3.0) * self._view.viewPixelSize()[0]
        if pole.value.real > at.x():
            return _spot(at + QPointF(way, 0.0), "t2", 1.5 * SIZE, colour, colour)
        return _spot(at + QPointF(0.0, way), "t1", 1.5 * SIZE, colour, colour)

    def _choose(self, pole: Pole | None) -> None:
        if pole != self._chosen:
            self._chosen = pole
            said = pole.text if pole is not None else ""
            self.setAccessibleDescription(said)
            self.read.emit(said)
            self._show()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Read the pole under the pointer, or move the held one."""
        assert event is not None
        if self._place is not None:
            self._want(self._value(event.position()))
            return
        pole = self._under(event.position())
        self._choose(pole)
        can = self._can_move(pole)
        self.viewport().setCursor(
            Qt.CursorShape.OpenHandCursor if can else Qt.CursorShape.ArrowCursor
        )

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Grab the proposed pole under the pointer."""
        assert event is not None
        pole = self._under(event.position(), proposed=self._movable)
        if event.button() == Qt.MouseButton.LeftButton and self._can_move(pole):
            assert pole is not None
            self._choose(pole)
            self._take(pole)
            self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Release the pole."""
        self._let_go()

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        """Release a pole that was moved by keys."""
        assert event is not None
        if Qt.Key(event.key()) in ARROWS and not event.isAutoRepeat():
            self._let_go()
        else:
            super().keyReleaseEvent(event)

    def _under(self, here: QPointF, *, proposed: bool = False) -> Pole | None:
        """Return the pole under the pointer; on request only among the proposed ones."""
        ways = [
            (math.hypot(here.x() - at.x(), here.y() - at.y()), index)
            for index, at in enumerate(map(self.place, self.poles))
            if self.poles[index].proposed or not proposed
        ]
        way, index = min(ways, default=(NEAR + 1.0, 0))
        return self.poles[index] if way <= NEAR else None

    def _value(self, here: QPointF) -> complex:
        """Return the value at a position in the widget [1/s], in the upper half of the plane."""
        at, ((left, right), (low, high)) = self._view.mapSceneToView(here), self._view.viewRange()
        return complex(min(max(at.x(), left), right), min(max(at.y(), low), high))

    def _can_move(self, pole: Pole | None) -> bool:
        return self._movable and pole is not None and pole.proposed

    def _take(self, pole: Pole) -> None:
        self._place = pole.value
        self.taken.emit(pole)
        self._show()

    def _want(self, place: complex) -> None:
        self._place = place
        self.wanted.emit(place)
        self._show()

    def _let_go(self) -> None:
        if self._place is not None:
            self._place = None
            self.released.emit()
            self._show()

    def _step(self, way: complex) -> None:
        """Move the selected pole by one step."""
        pole = self._chosen
        if pole is None or not self._can_move(pole):
            return
        if self._place is None:
            self._take(pole)
        assert self._place is not None
        moved = self._place + MOVED * abs(pole.value) * way
        self._want(complex(moved.real, max(moved.imag, 0.0)))

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom."""
        assert event is not None
        self.zoom(0.8 if event.angleDelta().y() > 0 else 1.25)
        event.accept()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Select another pole, move one, or zoom."""
        assert event is not None
        key = Qt.Key(event.key())
        if self._movable and key in ARROWS and event.modifiers() & SHIFT:
            self._step(ARROWS[key])
        elif key == Qt.Key.Key_Escape and self._place is not None:
            self._place = None
            self.given_up.emit()
            self._show()
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Minus, Qt.Key.Key_Equal):
            self.zoom(1.25 if key is Qt.Key.Key_Minus else 0.8)
        elif key in (Qt.Key.Key_Left, Qt.Key.Key_Right) and self.poles:
            move = -1 if key is Qt.Key.Key_Left else 1
            order = sorted(self.poles, key=lambda pole: (pole.value.real, pole.value.imag))
            at = order.index(self._chosen) + move if self._chosen in order else len(order) - 1
            self._choose(order[at % len(order)])
        else:
            super().keyPressEvent(event)


def _spot(
    at: QPointF, symbol: str, size: float, colour: QColor, fill: QColor | None = None
) -> Spot:
    pen = pg.mkPen(colour, width=1.5)
    return {"pos": at, "symbol": symbol, "size": size, "pen": pen, "brush": fill}


class PolesCard(Card):
    """Shows the poles of the sampled closed loop, in continuous terms, and moves them.

    Args:
        workspace: colours and analysis.
        trial: the gains that are being tried.
        judgement: known results for the gains.

    Attributes:
        plane: the plot.
        loops: selects the loop whose gains a drag changes.
        reading: a pole in words, or what prevents its move.
    """

    def __init__(self, workspace: Workspace, trial: Trial, judgement: Judgement) -> None:
        super().__init__("Poles")
        self._judgement = judgement
        self.plane = PolePlane(workspace.look)
        self.plane.set_movable(True)
        set_tip(
            self.plane,
            "Drag a proposed pole, or press Shift and an arrow key: the gains of the chosen loop "
            "follow, as far as they can move it. What holds it is said below: a gain's limit, "
            "rotor lag, delays, filters",
        )
        self.loops = choice(
            "Loop whose gains move a pole",
            help="A dragged pole is moved by the gains of this loop",
        )
        self.reading = Sentence()
        self._trial = trial
        self._follower = Follower(workspace.analysis, MovePole, self)
        self._follower.answered.connect(self._hear)
        self._follower.refused.connect(self._hear_refusal)
        self._follower.set_seen(True)
        self.head.addWidget(self.loops)
        fill(self.body, (self.plane, 1), self.reading)
        self.plane.read.connect(self._hear_read)
        self.plane.taken.connect(self._take)
        self.plane.wanted.connect(self._want)
        self.plane.released.connect(self._release)
        self.plane.given_up.connect(self._give_up)
        judgement.changed.connect(self._show)
        self.begin()

    def begin(self) -> None:
        """Clear the last flight."""
        self.loops.clear()
        self._follower.forget()
        self._moved, self._pole = "", 0j
        self._base: dict[str, float] | None = None
        self._is_released = False
        self._obstacle = ""
        self._at: complex | None = None
        self._following = False
        self._read("")
        self._show()

    @property
    def loop(self) -> str:
        """Name of the loop whose gains a drag changes, "" for none."""
        return self.loops.currentData() or ""

    def choose_loop(self, name: str) -> None:
        """Select the loop whose gains move poles."""
        place = self.loops.findData(name)
        if place >= 0:
            self.loops.setCurrentIndex(place)

    def _take(self, pole: Pole) -> None:
        """Grab a pole of the proposed gains; everything until its release is one step of undo."""
        if self._base is None:
            self._trial.gains.begin_edit()
            self._base = dict(self._trial.judged)
            self._moved, self._pole = self.loop, pole.value
        self._obstacle, self._is_released = "", False

    def _want(self, place: complex) -> None:
        """Move it to a place [1/s]."""
        if self._base is not None:
            linked = self._trial.linked_with(self._moved)
            self._follower.ask(MovePole(self._base, self._moved, self._pole, place, linked))

    def _release(self) -> None:
        """End the drag, after the last answer."""
        self._is_released = True
        if self._base is not None and not self._follower.is_waiting:
            self._end()

    def _give_up(self) -> None:
        """Propose the gains from before the pole was grabbed."""
        if self._base is not None:
            names = self._trial.gains_of(self._moved)
            names += self._trial.linked_with(self._moved).values()
            self._propose({name: self._base[name] for name in names if name in self._base})
            self._follower.forget()
            self._end()

    def _hear(self, _: MovePole, moved: PoleMoved) -> None:
        if self._base is None:
            return
        self._propose(moved.gains)
        self._obstacle = moved.said
        self._follow(moved.pole)
        if self._is_released and not self._follower.is_waiting:
            self._end()

    def _hear_refusal(self, said: str) -> None:
        self._obstacle = said
        self._follow(self._pole)
        if self._is_released:
            self._end()

    def _propose(self, gains: Mapping[str, float]) -> None:
        self._trial.gains.propose_all(gains, f"Pole of {loop_label(self._moved)}")

    def _end(self) -> None:
        self._base, self._is_released = None, False
        self._trial.gains.end_edit()

    def _follow(self, value: complex) -> None:
        """Read the pole that is being moved, once its gains have been evaluated."""
        self._at = value
        self._follow_pole(value)
        self._read(self.plane.accessibleDescription())

    def _follow_pole(self, value: complex) -> None:
        self._following = True
        self.plane.follow_pole(value)
        self._following = False

    def _hear_read(self, said: str) -> None:
        """Read a pole; for a different one, clear the message about the last one."""
        if not self._following and self._base is None:
            self._obstacle, self._at = "", None
        self._read(said)

    def _show(self) -> None:
        now, flown = self._judgement.proposed, self._judgement.flown
        before = flown.poles if flown is not None and flown is not now else None
        self.plane.show_poles(shown_poles(before, now.poles if now is not None else None))
        if self._at is not None:
            self._follow_pole(self._at)
        if now is not None and now.loops:
            offer(self.loops, {each.name: loop_label(each.name) for each in now.loops})
        if caveat := self._judgement.caveat:
            self.said.say(caveat, "warning")
        elif now is not None:
            self.said.say(poles_headline(now.poles), "muted" if now.stable else "bad")
        else:
            self.said.say(self._judgement.said or "Not known yet.")

    def _read(self, said: str) -> None:
        """Show what prevents a pole's move, or else the pole under the pointer."""
        if self._obstacle:
            self.reading.say(self._obstacle, "warning")
        else:
            self.reading.say(said or HINT)
