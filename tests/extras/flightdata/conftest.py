"""A short flight and its log, and somebody who answers questions, as in the tests of the core."""

from tests.analysis.conftest import answer, caller, subject, work
from tests.logs.conftest import flown, log

__all__ = ["answer", "caller", "flown", "log", "subject", "work"]
