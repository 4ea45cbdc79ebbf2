"""Live flights of the default law fly as machine code from their start."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def flies_compiled(compiled):
    """Have the machine code before a flight begins."""
