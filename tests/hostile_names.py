"""Names that attack whoever shows them, and what may be shown of them."""

import unicodedata

from workbench.common.plain_text import plain_name

NAMES = (
    # markup: Qt's rich text, HTML, SVG, Markdown, matplotlib's formulas, Graphviz's labels
    "<img src=/dev/null>",
    "<b>bold</b><br><br><br><h1>large</h1>",
    "<a href='http://127.0.0.1/'>a link</a>",
    "<script>document.title='taken'</script>",
    "<svg onload=\"document.title='taken'\">",
    "<table><tr><td width=90000>wide",
    "<!-- the rest is a comment",
    "<?xml version='1.0'?><qt>rich",
    "&lt;img src=/dev/null&gt; &amp;&#27;",
    "![a picture](/dev/null)",
    "$\\frac{a}{b}$ $\\undefined$",
    '"]; graph [label="\\N\\G',
    "&File &Quit && all",
    "%s %n {0} {value} {__class__}",
    '=HYPERLINK("http://127.0.0.1/","a sum")',
    # terminals: C0, C1, DEL
    "\x1b[2J\x1b[Hall is well",
    "\x1b]0;a title\x07",
    "\x1b]52;c;cm0gLXJmIH4=\x07",
    "\x9b2Jeight bits",
    "\x90q\x9c\x8d\x85next line",
    "a\rOK\b\b\x7f\x00\x0e",
    "one\nworkbench: wrote nothing\n\ttwo",
    # order and invisibility of letters
    "abc\u202egpj.exe\u202c",
    "\u2066\u2067isolated\u2069\u200f\u061c",
    "zero\u200bwidth\ufeff\u00ad\u2060joined",
    "lines\u2028and\u2029paragraphs",
    "half \ud800 pairs \udfff",
    "Z\u0335\u0336\u0337" + "\u0301\u0302\u0303" * 200,
    # length
    "x" * 1_000_000,
    "<b>y</b> " * 111_111,
)
"""30 of them."""
ACTING = {"Cc", "Cf", "Cs", "Zl", "Zp"}
LONGEST = 20_000


def acting(text: str, kept: str = "\n\t") -> list[str]:
    """Return the characters of a text that a terminal or a page would obey."""
    return [each for each in text if unicodedata.category(each) in ACTING and each not in kept]


def seen(name: str) -> str:
    """Return what stands for a name where it is shown."""
    return plain_name(name)
