"""Help on every card of every screen: two sentences, and a link that leads to a heading."""

import re

import pytest
from PyQt6.QtCore import QCoreApplication
from PyQt6.QtGui import QWhatsThisClickedEvent
from PyQt6.QtWidgets import QApplication, QWidget

from workbench.common.resources import docs_dir
from workbench.gui.help import CARDS, DocsBrowser, card_text, show_docs
from workbench.gui.home.cards import Card
from workbench.gui.screen_table import SCREENS


def cards(screen):
    """All that stands on a ground of its own, whatever class it is of."""
    for each in screen.findChildren(QWidget):
        if isinstance(each, Card) or "card" in str(each.property("class") or "").split():
            yield each


def help_of(widget):
    """What Shift+F1 and a click show: its own words, or those of what it stands in."""
    while widget is not None and not widget.whatsThis():
        widget = widget.parentWidget()
    return widget.whatsThis() if widget is not None else ""


def headings(page):
    """Anchors of a page, by GitHub's rule, out of the text alone."""
    lines = (docs_dir() / page).read_text(encoding="utf-8").splitlines()
    found = [line.lstrip("#").strip().lower() for line in lines if re.match("#{1,4} ", line)]
    return {re.sub("[^a-z0-9 _-]", "", each).replace(" ", "-") for each in found}


def test_every_card_of_every_screen_has_help(shared_window, case):
    counted, shown = 0, set()
    for row in SCREENS:
        shared_window.show_screen(row.name)
        screen = shared_window.stack.screen_of(row.name)
        QApplication.processEvents()  # only then all stands where it belongs
        for card in cards(screen):
            with case(f"{row.name}: {type(card).__name__} {card.accessibleName()}"):
                assert help_of(card), "has no help"
                counted += 1
                shown.add(help_of(card))
    assert counted > 35
    tabs = shared_window.stack.screen_of("visualization").tabs
    shown |= {help_of(tabs.widget(place)) for place in range(tabs.count())}
    shown.add(help_of(shared_window.stack.screen_of("tuning").panel))
    assert shown == set(map(card_text, CARDS))  # and none in the table is of no card


def test_help_is_two_sentences_and_its_link_leads_to_a_heading(case):
    for title, (means, read, link) in CARDS.items():
        with case(title):
            for said in (means, read):
                assert said[0].isupper() and said.endswith(".")
                assert not re.search(r"[.!?] [A-Z]", said)
            page, _, heading = link.partition("#")
            assert heading in headings(page)


@pytest.mark.parametrize("link", sorted({page for _, _, page in CARDS.values()}))
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


def test_a_click_on_the_link_of_a_card_opens_the_page(shared_window, qtbot):
    shared_window.show_screen("tuning")
    card = shared_window.stack.screen_of("tuning").margins
    QCoreApplication.sendEvent(card, QWhatsThisClickedEvent("linear.md#the-judgement"))
    (dialog,) = [each for each in QApplication.topLevelWidgets() if each.windowTitle() == "Docs"]
    assert dialog.isVisible()
    assert dialog.findChild(DocsBrowser).textCursor().block().text() == "The judgement"
    dialog.close()


def test_a_page_that_is_not_there_is_a_sentence(qtbot):
    dialog = show_docs("nowhere.md")
    qtbot.addWidget(dialog)
    assert "nowhere.md is not among the docs" in dialog.findChild(DocsBrowser).toPlainText()
