"""The card of poles: those that fly, and where the proposed gains would move them."""

from PyQt6.QtWidgets import QWidget

from workbench.gui.tuning.card import Card, Sentence
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.pole_plane import PolePlane
from workbench.gui.tuning.pole_points import poles_headline, shown_poles
from workbench.gui.workspace import Workspace


class PolesCard(Card):
    """Shows the poles of the sampled closed loop, in continuous terms.

    Args:
        workspace: colours.
        judgement: what is known of the gains.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(
        self, workspace: Workspace, judgement: Judgement, parent: QWidget | None = None
    ) -> None:
        super().__init__("Poles", parent)
        self._judgement = judgement
        self.plane = PolePlane(workspace.look)
        self.reading = Sentence()
        self.body.addWidget(self.plane, 1)
        self.body.addWidget(self.reading)
        self.plane.read.connect(self._read)
        judgement.changed.connect(self._show)
        self._read("")
        self._show()

    def _show(self) -> None:
        now, flown = self._judgement.proposed, self._judgement.flown
        before = flown.poles if flown is not None and flown is not now else None
        self.plane.show_poles(shown_poles(before, now.poles if now is not None else None))
        if caveat := self._judgement.caveat:
            self.said.say(caveat, "warning")
        elif now is not None:
            self.said.say(poles_headline(now.poles), "muted" if now.stable else "bad")
        else:
            self.said.say(self._judgement.said or "Not known yet.")

    def _read(self, said: str) -> None:
        self.reading.say(said or "● proposed   ○ flown   ✕ unstable; wheel zooms")
