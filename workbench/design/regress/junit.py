"""Results as JUnit XML, which every CI system reads."""

import re
from collections.abc import Sequence
from itertools import groupby
from xml.etree import ElementTree

from workbench.design.regress.verdict import CaseResult

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_xml(results: Sequence[CaseResult]) -> str:
    """Return a test suite a spec and a test case a case, as XML text."""
    top = ElementTree.Element("testsuites", {"name": "workbench regress"} | _counts(results))
    for spec, group in groupby(results, key=lambda result: result.spec):
        cases = list(group)
        suite = ElementTree.SubElement(top, "testsuite", {"name": spec} | _counts(cases))
        for result in cases:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                classname=spec,
                name=result.case,
                file=str(result.path),
                time=f"{result.seconds:.3f}",
            )
            if not result.passed:
                failure = ElementTree.SubElement(
                    case, "failure", message=_clean(result.failures[0]), type="regression"
                )
                failure.text = _clean("\n".join(result.story))
    ElementTree.indent(top)
    return ElementTree.tostring(top, encoding="unicode", xml_declaration=True) + "\n"


def _counts(results: Sequence[CaseResult]) -> dict[str, str]:
    failed = sum(not result.passed for result in results)
    return {
        "tests": str(len(results)),
        "failures": str(failed),
        "errors": "0",
        "skipped": "0",
        "time": f"{sum(result.seconds for result in results):.3f}",
    }


def _clean(text: str) -> str:
    """Return text without what XML cannot hold."""
    return _NOT_XML.sub("?", text)
