"""What is said of many results together."""

from collections.abc import Sequence

from workbench.design.regress.verdict import CaseResult


def summary(results: Sequence[CaseResult]) -> str:
    """Return how many passed or failed, in words; and how many were skipped."""
    skipped = sum(result.skipped for result in results)
    beside = f", {skipped} skipped" if skipped else ""
    count, failed = len(results) - skipped, sum(not result.passed for result in results)
    if not count:
        return "the case was skipped" if skipped == 1 else f"all {skipped} cases were skipped"
    if 0 < failed < count:
        return f"{failed} of {count} cases failed{beside}"
    word = "failed" if failed else "passed"
    return (f"the case {word}" if count == 1 else f"all {count} cases {word}") + beside


def since_baseline(results: Sequence[CaseResult]) -> list[str]:
    """Return what differs from the baselines, a sentence for all specs that say the same.

    It names its specs, but where it is all of several.
    """
    specs = {result.spec for result in results}
    saying: dict[str, dict[str, None]] = {}
    for result in results:
        if result.changed:
            saying.setdefault(result.changed, {})[result.spec] = None
    return [
        f"{'' if 1 < len(specs) == len(names) else ', '.join(names) + ': '}"
        f"since the baseline: {changed}"
        for changed, names in saying.items()
    ]
