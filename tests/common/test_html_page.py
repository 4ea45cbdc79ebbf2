"""Pages of reports: complete HTML, with texts from outside as texts."""

import re
from html.parser import HTMLParser

from workbench.common.html_page import html_page, html_table


class Seen(HTMLParser):
    """The elements of a page, and the class and text of each cell."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[str] = []
        self.cells: list[tuple[str, str]] = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.elements.append(tag)
        if tag in ("td", "th"):
            self.cells.append((dict(attrs).get("class") or "", ""))
        if tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            kind, text = self.cells.pop()
            self.cells.append((kind, text + data))


def test_a_page_closes_what_it_opens_and_shows_its_title_as_text():
    page = html_page("a <b> & c", "<p>body</p>")
    seen = Seen(page)
    assert not seen.open
    assert seen.elements[0] == "html" and "b" not in seen.elements
    assert page.count("a &lt;b&gt; &amp; c") == 2  # title and heading
    assert "<h1><i>own</i></h1>" in html_page("a", "", "<i>own</i>")
    assert "<body>" in page and '<body class="wide">' in html_page("a", "", wide=True)


def test_each_class_has_a_style():
    """One of `td.number` alone left the heads of numbers at the left."""
    style = html_page("", "").partition("<style>")[2].partition("</style>")[0]
    for rule in ("body.wide", ".number", ".note", ".failed", ".passed"):
        assert re.search(rf"(?m)(^|[}}] ?){re.escape(rule)} {{", style), rule


def test_a_table_shows_texts_and_marks_numbers_and_failures():
    rows = [["<i>x</i>", "1"], ["bad", "2"]]
    seen = Seen(html_table(("name", "n"), rows, kinds={1: "number"}, failed="bad"))
    assert not seen.open and "i" not in seen.elements
    assert seen.cells == [
        ("", "name"),
        ("number", "n"),
        ("", "<i>x</i>"),
        ("number", "1"),
        ("failed", "bad"),
        ("number", "2"),
    ]
    assert Seen(html_table((), rows)).elements.count("tr") == 2  # no empty row of names
