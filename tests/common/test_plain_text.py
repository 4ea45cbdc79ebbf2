"""Text from outside: what acts on a terminal or reorders a line is seen, and nothing is endless."""

import json
import sys
import unicodedata

from workbench.common.errors import MAX_ERROR_CHARS, WorkbenchError
from workbench.common.plain_text import (
    MAX_SHOWN_NAME_CHARS,
    escaped_json,
    file_stem,
    html_text,
    plain_name,
    plain_text,
    visible,
)

ACTS = {"Cc", "Cf", "Cs", "Zl", "Zp"}
"""Categories of characters that are not seen themselves."""
SEEN = "\n\t\N{ZERO WIDTH JOINER}\N{ZERO WIDTH NON-JOINER}"
EVERY = range(sys.maxunicode + 1)
"""Codes; a list of all characters would be made in each process that collects this file."""


def test_every_character_that_acts_becomes_an_escape_and_no_letter_changes():
    kinds = {each: unicodedata.category(each) for each in map(chr, EVERY)}
    acting = [each for each, kind in kinds.items() if kind in ACTS and each not in SEEN]
    assert {"\x00", "\x1b", "\x7f", "\x9b", "\u202e", "\u2067", "\u2028", "\ufeff"} <= {*acting}
    for each in acting:
        seen = visible(f"a{each}b")
        assert seen.isascii() and seen.isprintable(), ascii(each)
        assert seen.encode().decode("unicode_escape") == f"a{each}b"
    letters = "".join(each for each, kind in kinds.items() if kind not in {*ACTS, "Co", "Cn"})
    assert visible(letters + SEEN) == letters + SEEN


def test_the_rows(case):
    for text, line in (
        ("base_link", "base_link"),
        ("<b>&amp;</b>", "<b>&amp;</b>"),
        ("\x1b[2Jgone", r"\x1b[2Jgone"),
        ("\x9b31mred", r"\x9b31mred"),
        ("a\u202eb", r"a\u202eb"),
        ("one\ntwo\tthree\r", r"one\ntwo\tthree\r"),
        ("21 °C, ½ m/s²", "21 °C, ½ m/s²"),
        ("م\N{ZERO WIDTH NON-JOINER}خ 👩\N{ZERO WIDTH JOINER}🚀",) * 2,
        ("\N{NO-BREAK SPACE}\N{THIN SPACE}",) * 2,
        ("\udcff", r"\udcff"),
    ):
        with case(text):
            assert plain_name(text) == line


def test_a_text_is_cut_and_says_how_long_it_is():
    assert plain_text("a" * 2000) == "a" * 2000
    assert plain_text("a" * 2001) == "a" * 2000 + "… (2,001 characters)"
    assert plain_name("x" * 1_000_000) == "x" * MAX_SHOWN_NAME_CHARS + "… (1,000,000 characters)"
    # escapes are longer than what they stand for
    assert plain_name("\x1b" * 79) == r"\x1b" * (MAX_SHOWN_NAME_CHARS // 4) + "… (79 characters)"


def test_a_file_s_name_names_no_other_folder(case):
    for name, stem in (
        ("dh_drone", "dh_drone"),
        ("My drone.v2", "My drone.v2"),
        ("../../.bashrc", "_.._.bashrc"),
        ("/etc/passwd", "_etc_passwd"),
        ("..\\x", "_x"),
        ("a\0b\n", r"a_x00b_n"),
        ("..", "unnamed"),
        ("", "unnamed"),
    ):
        with case(name):
            assert file_stem(name) == stem


def test_json_stays_the_same_json():
    given = {
        "".join(map(chr, EVERY[:0x300])): [
            "".join(map(chr, EVERY[0xDBFE:0xDC00])),
            "\udc00",
            "\U000e0041\U0001f680",
        ]
    }
    text = escaped_json(json.dumps(given, ensure_ascii=False, indent=1))
    assert json.loads(text) == given
    assert visible(text) == text
    assert "é" in text and "\U0001f680" in text


def test_html_has_no_tags_and_nothing_that_acts():
    assert html_text("<img src='x'>&\x9b\u202e\"") == (
        r"&lt;img src=&#x27;x&#x27;&gt;&amp;\x9b\u202e&quot;"
    )


def test_a_message_has_an_end_however_long_what_it_echoes_is():
    said = str(WorkbenchError(f"a.yaml:1: '{'x' * 1_000_000}' is not a number: write one"))
    assert said.startswith("a.yaml:1: 'xxx") and said.endswith("is not a number: write one")
    assert len(said) <= MAX_ERROR_CHARS
