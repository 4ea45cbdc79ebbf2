"""Help of a card: two sentences, and a link that leads to a heading."""

import re

import pytest

from workbench.common.resources import docs_dir
from workbench.gui.help import CARD_HELP, DocsBrowser, show_docs


def headings(page):
    """Anchors of a page, by GitHub's rule, out of the text alone."""
    lines = (docs_dir() / page).read_text(encoding="utf-8").splitlines()
    found = [line.lstrip("#").strip().lower() for line in lines if re.match("#{1,4} ", line)]
    return {re.sub("[^a-z0-9 _-]", "", each).replace(" ", "-") for each in found}


def test_help_is_two_sentences_and_its_link_leads_to_a_heading(case):
    for title, (means, read, link) in CARD_HELP.items():
        with case(title):
            for said in (means, read):
                assert said[0].isupper() and said.endswith(".")
                assert not re.search(r"[.!?] [A-Z]", said)
            page, _, heading = link.partition("#")
            assert heading in headings(page)


@pytest.mark.parametrize("link", sorted({page for _, _, page in CARD_HELP.values()}))
def test_the_page_opens_at_its_heading(qtbot, link):
    dialog = show_docs(link)
    qtbot.addWidget(dialog)
    browser = dialog.findChild(DocsBrowser)
    at = browser.textCursor().block()
    top = browser.cursorRect().top()
    bar = browser.verticalScrollBar()
    assert abs(top) < 30 or bar.value() == bar.maximum()
    assert at.blockFormat().headingLevel()
    assert at.text().lower().replace(" ", "-").startswith(link.split("#")[1][:5])


def test_a_page_that_is_not_there_is_a_sentence(qtbot):
    dialog = show_docs("nowhere.md")
    qtbot.addWidget(dialog)
    assert "nowhere.md is not among the docs" in dialog.findChild(DocsBrowser).toPlainText()
