"""What commands print."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.commands.printing import print_table, to_json


@dataclass(frozen=True)
class Record:
    name: str
    value: float
    children: tuple["Record", ...] = ()


def test_dataclasses_become_objects_and_what_is_not_finite_null():
    record = Record("a", math.nan, (Record("b", math.inf), Record("c", 1.5)))
    assert json.loads(to_json({"record": record, "path": Path("x"), "number": np.float64(2)})) == {
        "record": {
            "name": "a",
            "value": None,
            "children": [
                {"name": "b", "value": None, "children": []},
                {"name": "c", "value": 1.5, "children": []},
            ],
        },
        "path": "x",
        "number": 2.0,
    }


def test_truth_whole_numbers_and_none_stay_what_they_are():
    assert json.loads(to_json([True, None, 3, "m/s²"])) == [True, None, 3, "m/s²"]


def test_numbers_and_arrays_of_numpy_are_those_of_json():
    given = {"whole": np.int64(3), "true": np.bool_(True), "each": np.array([[1.5, np.nan]])}
    assert json.loads(to_json(given)) == {"whole": 3, "true": True, "each": [[1.5, None]]}


def test_columns_are_aligned_texts_left_and_numbers_right(capsys):
    print_table([("name", "value"), ("a", "1.25"), ("longer", "10")])
    assert capsys.readouterr().out == "name    value\na        1.25\nlonger     10\n"
