"""Names from outside in pictures and pages: shown as they are, not typeset, rendered or run."""

import io
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import workbench
from tests.hostile_names import NAMES, acting
from workbench.common.plain_text import html_text, plain_name, plain_text, visible
from workbench.design.plots import (
    curve_name,
    inline_svg,
    note,
    styled,
    tick_name,
    write_png,
)
from workbench.design.regress.page import junit_xml, results_page
from workbench.design.regress.spec import SpecLimit
from workbench.design.regress.verdict import CaseResult, LimitCheck

PACKAGE = Path(workbench.__file__).parent


class Page(HTMLParser):
    """The tags and the text of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags, self.text = [], ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, tuple(name for name, _ in attrs)))

    def handle_data(self, data):
        self.text += data


@styled
def drawn(name: str) -> Figure:
    """A figure that has a name in each place for text."""
    figure = Figure(figsize=(6.0, 4.0))
    figure.suptitle(name)
    axes, other = figure.subplots(1, 2)
    axes.plot([1.0, 2.0], [1.0, 2.0], label=curve_name(name))
    axes.legend()
    axes.set_title(name)
    axes.set_xlabel(name)
    note(axes, name, (0.0, 0.0))
    other.barh([0, 1], [1.0, 2.0])
    other.set_yticks([0, 1], [tick_name(name), "plain"])
    other.semilogx([0.1, 1000.0], [0.0, 1.0])
    return figure


@pytest.mark.filterwarnings("ignore:Glyph")  # that no font has
def test_a_figure_shows_names_as_they_are(case):
    for name in (*NAMES, "_first", "$x$", "a $ b"):
        with case(name[:60]):
            figure = drawn(name)
            axes, other = figure.axes
            texts = [figure._suptitle, axes.title, axes.xaxis.label, *axes.texts]
            legend = axes.get_legend()
            texts += legend.get_texts()
            assert len(legend.get_texts()) == 1
            for text in texts:
                assert text._preprocess_math(text.get_text()) == (text.get_text(), False)
                assert acting(text.get_text()) == []
                assert len(text.get_text()) < 400
            assert texts[0].get_text() == plain_text(name, 300).replace("\t", " ")
            tick = other.get_yticklabels()[0]
            shown, is_math = tick._preprocess_math(tick.get_text())
            assert not is_math
            assert shown == plain_name(name, 40)


def test_numbers_at_axes_are_typeset():
    figure = drawn("plain")
    FigureCanvasAgg(figure).draw()
    powers = [each for each in figure.axes[1].get_xticklabels() if each.get_text()]
    assert all(each._preprocess_math(each.get_text())[1] for each in powers) and powers


@pytest.mark.filterwarnings("ignore:Glyph")
def test_pictures_are_files_that_others_read(case):
    for name in NAMES:
        with case(name[:60]):
            svg = inline_svg(drawn(name))
            tags = {each.tag for each in ElementTree.fromstring(svg).iter()}
            assert not {tag for tag in tags if re.search("script|image|foreign|}a$", str(tag))}
            assert acting(svg) == []


@pytest.mark.parametrize("name", ["$\\frac{a}{b}$", "x" * 1_000_000], ids=["math", "long"])
def test_a_picture_is_written(name):
    data = io.BytesIO()
    write_png(drawn(name), data)
    assert data.getvalue().startswith(b"\x89PNG")


def results(name):
    check = LimitCheck(name, name, 2.0, SpecLimit(max=1.0), doubt=name)
    return (
        CaseResult(name, Path(name[:50].replace("\0", "")), name, checks=(check,)),
        CaseResult(name, Path("a"), name, trouble=name),
    )


def test_a_page_has_the_tags_of_plain_names(case):
    plain = Page(results_page(results("plain"), "plain"))
    for name in NAMES:
        with case(name[:60]):
            text = results_page(results(name), name)
            page = Page(text)
            assert page.tags == plain.tags
            assert acting(text) == []
            assert plain_text(name) in page.text
            assert len(text) < 100_000


def test_junit_is_xml(case):
    for name in NAMES:
        with case(name[:60]):
            page = ElementTree.fromstring(junit_xml(results(name)))
            assert [each.get("name") for each in page.iter("testcase")] == [visible(name)] * 2
            assert [each.tag for each in page.iter()][:3] == ["testsuites", "testsuite", "testcase"]


def test_html_is_escaped_by_the_helper(case):
    """`html_text` also bounds the text, and shows what acts in it."""
    allowed = {"common/plain_text.py", "gui/labels.py", "plant/meshes/side_files.py"}
    for path in sorted(PACKAGE.rglob("*.py")):
        file = path.relative_to(PACKAGE).as_posix()
        with case(file):
            imports = re.search(r"^\s*(import|from) html\b", path.read_text(), re.MULTILINE)
            assert not imports or file in allowed


def test_no_script_of_a_page_makes_html_of_text(case):
    for path in PACKAGE.rglob("*.js"):
        with case(path.name):
            assert not re.search(
                r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|DOMParser|\beval\(",
                path.read_text(),
            )


def test_html_text_is_text(case):
    for name in NAMES:
        with case(name[:60]):
            page = Page(f"<p title='{html_text(name)}'>{html_text(name)}</p>")
            assert page.tags == [("p", ("title",))]
            assert np.all(page.text == plain_text(name))
