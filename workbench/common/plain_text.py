"""Text from outside (names, messages, files), made safe to show.

Control characters move a terminal's cursor and change its colours, bidirectional controls reorder
what stands around them, and a name of a megabyte takes seconds to lay out. Here the former become
escapes as Python writes them, and the latter is cut, with its length. Markup is not a matter of
this file: whoever shows text as HTML escapes it in addition.
"""

import re

MAX_SHOWN_NAME_CHARS = 80
"""Largest number of characters that are shown of a name."""
MAX_SHOWN_TEXT_CHARS = 2000
"""Largest number of characters that are shown of a text in a window, a picture or a page."""
_UNUSUAL_CHARS = re.compile(r"[^ -~\n\t]+")
_JOINERS = "\N{ZERO WIDTH NON-JOINER}\N{ZERO WIDTH JOINER}"
"""Persian, Hindi and emoji are not written without them."""


def visible(text: str) -> str:
    """Return a text with escapes for all characters that act instead of being seen.

    These are the control characters but line feed and tab, bidirectional controls and other format
    characters, line and paragraph separators, half surrogate pairs, and unassigned code points.
    """
    return text if text.isprintable() else _UNUSUAL_CHARS.sub(_escaped_run, text)


def plain_text(text: str, longest: int = MAX_SHOWN_TEXT_CHARS) -> str:
    """Return `visible` text of limited length; where it is cut, it ends with its full length."""
    seen = visible(text[:longest])
    if len(text) <= longest and len(seen) <= longest:
        return seen
    return f"{seen[:longest]}\N{HORIZONTAL ELLIPSIS} ({len(text):,} characters)"


def plain_name(name: str, longest: int = MAX_SHOWN_NAME_CHARS) -> str:
    """Return a name as one line of limited length, with its full length where it is cut."""
    text = plain_text(name, longest)
    return text if text.isprintable() else text.replace("\n", "\\n").replace("\t", "\\t")


def file_stem(name: str) -> str:
    """Return a name for a file of that name, which is never in another folder or hidden."""
    return re.sub(r"[/\\]", "_", plain_name(name)).lstrip(".") or "unnamed"


def html_text(text: str) -> str:
    """Return `plain_text` as HTML, also for the value of an attribute."""
    import html

    return html.escape(plain_text(text))


def escaped_json(text: str) -> str:
    """Return JSON without characters that act: it is the same JSON, as strings alone have them."""
    import json

    def escapes(run: re.Match[str]) -> str:
        return "".join(each if _is_seen(each) else json.dumps(each)[1:-1] for each in run[0])

    return _UNUSUAL_CHARS.sub(escapes, text)


def _escaped_run(run: re.Match[str]) -> str:
    return "".join(
        each if _is_seen(each) else each.encode("unicode_escape").decode() for each in run[0]
    )


def _is_seen(character: str) -> bool:
    """Return whether a character is a printed one, a space of any width, or joins letters."""
    return character.isprintable() or character in _JOINERS or _is_space(character)


def _is_space(character: str) -> bool:
    import unicodedata

    return unicodedata.category(character) == "Zs"
