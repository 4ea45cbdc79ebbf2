"""Remarks on what was repaired, assumed, missing or ignored in a description."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from workbench.common.plain_text import MAX_SHOWN_TEXT_CHARS, plain_name, plain_text

RemarkKind = Literal["repaired", "assumed", "missing", "held", "ignored"]
REMARK_HEADINGS: dict[RemarkKind, str] = {
    "repaired": "repaired",
    "assumed": "assumed",
    "missing": "missing",
    "held": "held in flight",
    "ignored": "not used",
}
"""Heading of each kind of remark."""


@dataclass(frozen=True)
class DescriptionRemark:
    """One thing that the reader of a description should know.

    Attributes:
        kind: `repaired`: different in the file; `assumed`: not in the file; `missing`: named in the
            file but not found; `held`: a joint that does not move; `ignored`: in the file but not
            used.
        file: the one concerned.
        element: the element, in words a user can search for: `link 'rotor_0'`.
        text: what was done about it, a clause that can follow a colon.
    """

    kind: RemarkKind
    file: Path
    element: str
    text: str

    def __str__(self) -> str:
        return f"{self.file}: {self.element}: {self.text}"


def counts_by_kind(remarks: Sequence[DescriptionRemark]) -> str:
    """Return the number of remarks of each kind: "2 repaired, 1 missing"."""
    counts = Counter(remark.kind for remark in remarks)
    return ", ".join(
        f"{counts[kind]} {word}" for kind, word in REMARK_HEADINGS.items() if counts[kind]
    )


@dataclass
class Remarks:
    """Remarks in the order of their occurrence, without duplicates."""

    _found: dict[DescriptionRemark, None] = field(default_factory=dict)

    @property
    def found(self) -> list[DescriptionRemark]:
        """All remarks."""
        return list(self._found)

    def add(self, kind: RemarkKind, file: Path, element: str, text: str) -> None:
        """Add a remark, unless the same one is there; names in it come from the file."""
        element = plain_name(element, MAX_SHOWN_TEXT_CHARS)
        self._found.setdefault(DescriptionRemark(kind, file, element, plain_text(text)))
