"""The package has public names of its own."""

import re
from pathlib import Path

import pytest

from workbench.extras import flightdata


def test_each_public_name_is_written_once_and_can_be_loaded():
    lines = Path(f"{flightdata.__file__}i").read_text().splitlines()[2:]
    assert lines == sorted(set(lines))
    said = [re.fullmatch(r"from (workbench\.[\w.]+) import (\w+) as \2", each) for each in lines]
    assert all(said) and flightdata.__all__ == sorted(each[2] for each in said)
    for name in flightdata.__all__:
        assert callable(getattr(flightdata, name)), name
    with pytest.raises(AttributeError, match="has no attribute 'Drone'"):
        _ = flightdata.Drone
