"""A picture and its numbers in a card: beside each other, or one above the other."""

from dataclasses import dataclass

from PyQt6.QtCore import QRectF

WIDE = 1.2
"""From this ratio of width to height on, they stand beside each other."""
PICTURE = 0.6
"""Most of the width that the picture takes then."""


@dataclass(frozen=True)
class Beside:
    """Two places in a card."""

    picture: QRectF
    numbers: QRectF


def beside(body: QRectF, gap: float, numbers_height: float, share: float = PICTURE) -> Beside:
    """Return the places.

    Args:
        body: of the card.
        gap: between the two [px].
        numbers_height: that the numbers need where they stand below [px].
        share: most of the width that the picture takes where it stands on the left.
    """
    if body.width() >= WIDE * body.height():
        width = min(body.height(), share * body.width())
        picture = QRectF(body.left(), body.top(), width, body.height())
        numbers = QRectF(body)
        numbers.setLeft(picture.right() + gap)
        return Beside(picture, numbers)
    picture, numbers = QRectF(body), QRectF(body)
    picture.setBottom(body.bottom() - numbers_height - gap)
    numbers.setTop(body.bottom() - numbers_height)
    return Beside(picture, numbers)
