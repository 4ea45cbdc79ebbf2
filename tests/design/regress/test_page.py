"""The page of results, and JUnit XML, read by the standard library's parser."""

import re
from pathlib import Path
from xml.etree import ElementTree

from workbench.design.regress.page import junit_xml, results_page
from workbench.design.regress.spec import SpecLimit
from workbench.design.regress.verdict import CaseResult, LimitCheck

GOOD = CaseResult("a", Path("a.workbench.yaml"), "fine", seconds=0.5)
LOST = CaseResult(
    "b", Path("b.workbench.yaml"), 'the "<x>" case', trouble="diverged\x00 at t = 1 s & on"
)
FAILED = CaseResult(
    "a",
    Path("a.workbench.yaml"),
    "slow",
    checks=(
        LimitCheck("t90", "s", 2.0, SpecLimit(max=1.0)),
        LimitCheck("peak", "m", 2.0, SpecLimit(max=1.0)),
    ),
    seconds=0.25,
)


def test_the_heads_of_numbers_stand_where_the_numbers_do():
    page = results_page([FAILED], "all")
    cells = re.findall(r'<(t[hd]) class="number">([^<]*)<', page)
    heads, numbers = ([text for tag, text in cells if tag == each] for each in ("th", "td"))
    assert heads == ["value", "demanded"]
    assert numbers[::2] == ["2 s", "2 m"]


def test_there_is_a_suite_a_spec_and_a_case_a_case():
    top = ElementTree.fromstring(junit_xml([GOOD, FAILED, LOST]))
    assert top.tag == "testsuites"
    assert (top.get("tests"), top.get("failures"), top.get("errors")) == ("3", "2", "0")
    suites = top.findall("testsuite")
    assert [suite.get("name") for suite in suites] == ["a", "b"]
    assert [suite.get("tests") for suite in suites] == ["2", "1"]
    cases = top.findall("testsuite/testcase")
    assert [case.get("name") for case in cases] == ["fine", "slow", 'the "<x>" case']
    assert [case.get("classname") for case in cases] == ["a", "a", "b"]
    assert cases[0].get("time") == "0.500"
    assert suites[0].get("time") == "0.750"


def test_a_failure_has_its_sentences_and_only_that_is_one():
    top = ElementTree.fromstring(junit_xml([GOOD, FAILED, LOST]))
    good, failed, lost = top.findall("testsuite/testcase")
    assert good.find("failure") is None
    failure = failed.find("failure")
    assert failure.get("message").startswith("t90 is 2 s")
    assert failure.text.splitlines()[1].startswith("peak is 2 m")
    assert lost.find("failure").get("message") == "diverged\\x00 at t = 1 s & on"


def test_a_file_without_failures():
    assert "failure>" not in junit_xml([GOOD])
    assert junit_xml([]).startswith("<?xml version=")
