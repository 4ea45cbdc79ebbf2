"""The card of poles: with the flown gains, and with the proposed ones, which can be dragged."""

from collections.abc import Mapping

from PyQt6.QtCore import pyqtSignal

from workbench.analysis.queries import MovePole
from workbench.analysis.replies import PoleMoved
from workbench.control.loop import loop_label
from workbench.gui.analysis import QueryStream
from workbench.gui.labels import set_tip
from workbench.gui.layout import choice, fill, hbox, tool_button
from workbench.gui.tuning.card import ToneLabel, TuningCard, set_items
from workbench.gui.tuning.judgement import StabilityFollower, with_caveat
from workbench.gui.tuning.pole import Pole, drawn_poles, leading_pole, poles_headline
from workbench.gui.tuning.pole_plane import PolePlane
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.workspace import Workspace

OWN_LOOP_TEXT = "Own loop"
NO_LOOP_TEXT = "No loop moves this pole by itself: choose the one whose gains shall move it."
POLES_LEGEND_TEXT = "● proposed, to be dragged   ○ flown   ✕ unstable"


class PolesCard(TuningCard):
    """Shows the poles of the sampled closed loop, in continuous terms, and moves them.

    Args:
        workspace: colours and analysis.
        trial: the gains that are being tried.
        judgement: known results for the gains.

    Attributes:
        plane: the plot.
        loops: selects the loop whose gains a drag changes: that of the pole, or one for all.
        reading: a pole in words, or what prevents its move.
        to_loop: shows the loop of the pole that was read last, or else of the leading one.
    """

    loop_wanted = pyqtSignal(str)
    """Name of the loop that should be shown."""

    def __init__(
        self, workspace: Workspace, trial: TuningTrial, judgement: StabilityFollower
    ) -> None:
        super().__init__("Poles")
        self._judgement = judgement
        self.plane = PolePlane(workspace.look)
        self.plane.set_movable(True)
        set_tip(
            self.plane,
            "Drag a proposed pole, or press Shift and an arrow key: the gains of its loop, or of "
            "the chosen one, follow as far as they can move it. What holds it is said below: a "
            "gain's limit, rotor lag, delays, filters",
        )
        self.loops = choice(
            "Loop whose gains move a pole",
            help="Whose gains move a dragged pole: those of the loop that it belongs to, which is "
            "named below, or those of one loop. Of poles on one another, the one of the chosen "
            "loop is taken",
        )
        self.reading = ToneLabel()
        help = "Show the frequency response of the loop that the pole belongs to"
        self.to_loop = tool_button("Its loop", self._go_to_loop, "compact", help)
        self._trial = trial
        self._queries = QueryStream(workspace.analysis, self, seen=True)
        self._queries.answered.connect(self._hear)
        self._queries.refused.connect(self._hear_refusal)
        self.loops.currentIndexChanged.connect(lambda _: self.prefer_loop(""))
        self.head.addWidget(self.loops)
        fill(self.body, (self.plane, 1), hbox((self.reading, 1), self.to_loop))
        self.plane.read.connect(self._hear_read)
        self.plane.taken.connect(self._take)
        self.plane.wanted.connect(self._want)
        self.plane.released.connect(self._release)
        self.plane.given_up.connect(self._give_up)
        judgement.changed.connect(self._show)
        self._seen = True
        self.begin()

    def begin(self) -> None:
        """Clear the last flight."""
        self.loops.clear()
        self._queries.forget()
        self._moved, self._pole = "", 0j
        self._base: dict[str, float] | None = None
        self._is_released = False
        self._obstacle = ""
        self._at: complex | None = None
        self._following = False
        self._last_read: Pole | None = None
        self._read("")
        self._show()

    def set_seen(self, seen: bool) -> None:
        """Draw the poles only while the card is visible."""
        self._seen = seen
        self._show()

    @property
    def loop(self) -> str:
        """Name of the loop whose gains a drag changes, "" for the one that the pole belongs to."""
        return self.loops.currentData() or ""

    def prefer_loop(self, name: str) -> None:
        """Take the pole of a loop, of several on one another, unless another one is chosen."""
        self.plane.loop = self.loop or name

    def _take(self, pole: Pole) -> None:
        """Grab a pole of the proposed gains; everything until its release is one step of undo."""
        self._obstacle, self._is_released = "", False
        loop = self.loop or pole.loop
        if self._base is None and loop:
            self._trial.gains.begin_edit()
            self._base = dict(self._trial.judged)
            self._moved, self._pole = loop, pole.value
        elif not loop:
            self._obstacle = NO_LOOP_TEXT
            self._read("")

    def _want(self, place: complex) -> None:
        """Move it to a place [1/s]."""
        if self._base is not None:
            linked = self._trial.linked_with(self._moved)
            self._queries.ask(MovePole(self._base, self._moved, self._pole, place, linked))

    def _release(self) -> None:
        """End the drag, after the last answer."""
        self._is_released = True
        if self._base is not None and not self._queries.is_waiting:
            self._end()

    def _give_up(self) -> None:
        """Propose the gains from before the pole was grabbed."""
        if self._base is not None:
            names = self._trial.gains_of(self._moved)
            names += self._trial.linked_with(self._moved).values()
            self._propose({name: self._base[name] for name in names if name in self._base})
            self._queries.forget()
            self._end()

    def _hear(self, _: MovePole, moved: PoleMoved) -> None:
        if self._base is None:
            return
        self._propose(moved.gains)
        self._obstacle = moved.said
        self._follow(moved.pole)
        if self._is_released and not self._queries.is_waiting:
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
        self._last_read = self.plane.chosen or self._last_read
        self._read(said)
        self._name_loop()

    def _show(self) -> None:
        now, flown = self._judgement.proposed, self._judgement.flown
        if now is not None and now.loops:
            names = (each.name for each in now.loops)
            set_items(self.loops, {"": OWN_LOOP_TEXT} | {name: loop_label(name) for name in names})
        if not self._seen:
            return
        self.plane.show_poles(drawn_poles(flown if flown is not now else None, now))
        if self._at is not None:
            self._follow_pole(self._at)
        if now is not None:
            headline, tone = poles_headline(self.plane.poles), "muted" if now.stable else "bad"
            self.said.say(*with_caveat(self._judgement.caveat, headline, tone))
        else:
            self.said.say(self._judgement.said or "Not known yet.")
        self._name_loop()

    @property
    def _pole_loop(self) -> str:
        """Loop of the pole that was read last, or else of the leading one; "" for none."""
        pole = self._last_read or leading_pole(self.plane.poles)
        return pole.loop if pole is not None else ""

    def _name_loop(self) -> None:
        loop = self._pole_loop
        self.to_loop.setEnabled(bool(loop))
        self.to_loop.setAccessibleName(f"Show the loop {loop_label(loop)}" if loop else "No loop")

    def _go_to_loop(self) -> None:
        self.loop_wanted.emit(self._pole_loop)

    def _read(self, said: str) -> None:
        """Show what prevents a pole's move, or else the pole under the pointer."""
        if self._obstacle:
            self.reading.say(self._obstacle, "warning")
        else:
            self.reading.say(said or POLES_LEGEND_TEXT)
