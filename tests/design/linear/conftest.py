"""The shipped drone's study, and float copies of the diagrams it linearises."""

import pytest

from workbench.design.linear.study import LinearStudy


@pytest.fixture(scope="session")
def study():
    return LinearStudy()
