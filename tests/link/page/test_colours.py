"""The page's colours can be told apart, light and dark."""

import re

from workbench.link.server import web

TEXT, EDGE = 4.5, 3.0
"""Ratios that WCAG 2.2 asks for (1.4.3 and 1.4.11)."""
PAIRS = [
    *((ink, paper, TEXT) for ink in ("text", "quiet") for paper in ("back", "card", "bad-back")),
    ("accent", "card", TEXT),
    ("on-accent", "accent", TEXT),
    ("bad", "card", TEXT),
    ("card", "bad", TEXT),
    ("bad", "back", TEXT),
    ("edge", "card", EDGE),
    ("edge", "back", EDGE),
    ("accent", "back", EDGE),
    ("good", "back", EDGE),
    ("obstacle", "card", EDGE),
    ("craft", "sky", EDGE),
    ("craft", "ground", EDGE),
]


def themes():
    text = web.page_files()["style.css"].decode()
    blocks = [dict(re.findall(r"--([\w-]+): #(\w{6})", each)) for each in text.split(":root")[1:3]]
    return {"light": blocks[0], "dark": blocks[1]}


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (0, 2, 4)]
    red, green, blue = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_contrast(case):
    for ink, paper, least in PAIRS:
        for theme in ["light", "dark"]:
            with case(ink, paper, least, theme):
                colours = themes()[theme]
                light, dark = sorted(
                    (luminance(colours[ink]), luminance(colours[paper])), reverse=True
                )
                assert (light + 0.05) / (dark + 0.05) >= least
