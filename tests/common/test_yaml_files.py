"""Oracle: the lines as counted by eye."""

from dataclasses import dataclass, field

import pytest
import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import check_schema, fast_loader, read_yaml

TEXT = """title: a
start:
  mode: off

  position:
  - 1.0
  - 2.0
script:
- at: 1
- at: 2
  set: {x: 1,
    y: 2}
"""


@pytest.fixture
def write(tmp_path):
    def write_yaml(text):
        path = tmp_path / "a.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write_yaml


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read_yaml(path)
    said = str(caught.value)
    assert "\n" not in said
    return said


def test_data_and_text_are_kept(write):
    path = write(TEXT)
    file = read_yaml(path)
    assert (file.path, file.text) == (path, TEXT)
    assert file.data["script"][1]["set"] == {"x": 1, "y": 2}


def test_every_key_has_its_line(case, write):
    for keys, line in [
        (("title",), 1),
        (("start",), 2),
        (("start", "mode"), 3),
        (("start", "position"), 5),
        (("start", "position", 1), 7),
        (("script", 0), 9),
        (("script", 0, "at"), 9),
        (("script", 1, "at"), 10),
        (("script", 1, "set", "y"), 12),
        (("script", 1, "set", "z"), 11),  # the nearest key above what is not there
        (("start", "velocity", 2), 2),
        (("nothing",), 1),
    ]:
        with case(keys, line):
            path = write(TEXT)
            assert read_yaml(path).where(*keys) == f"{path}:{line}: "


@pytest.mark.parametrize(
    ("text", "line"),
    [("a: [1\nb: 2\n", 2), ("a: 1\n b: 2\n", 2), ("a: 1\nb: '\n", 3), ("a: 1\nb: \t- c\n\td", 2)],
)
def test_what_is_not_yaml_is_named_with_its_line(write, text, line):
    path = write(text)
    assert fault(path).startswith(f"{path}:{line}: not YAML: ")


@pytest.mark.parametrize("text", ["", "- a\n", "a\n", "3\n"])
def test_a_file_without_keys_is_refused(write, text):
    path = write(text)
    assert fault(path).startswith(f"{path}:1: expected 'key: value' lines")


def test_a_key_given_twice_is_refused(write):
    """YAML forbids it, and silently taking the last one hides a mistake."""
    path = write("a: 1\nb: 2\na: 3\n")
    said = fault(path)
    assert said.startswith(f"{path}:3: ")
    assert "'a'" in said


@pytest.mark.parametrize("text", [b"a: \xff\n", b"a: \x01\n", b"a: !!python/name:os.system\n"])
def test_what_does_not_belong_into_a_yaml_file_is_refused(write, text):
    assert fault(write(text)).startswith(str(write(text)))


def test_a_missing_file_or_a_folder_is_named(tmp_path):
    assert fault(tmp_path / "gone.yaml").endswith("gone.yaml: no such file")
    assert fault(tmp_path).startswith(f"{tmp_path}: is a folder")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: &a [1, *a]", ":1: has an alias"),
        ("a: &a [1, 1]\nb: *a", ":2: has an alias"),
        ("a: " + "[" * 3000, ":1: is nested more than 20 deep"),
        ("a: 1" + ":59" * 5000, ":1: a number has more than 400 characters"),
        ("a: 0x" + "f" * 5000, ":1: a number has more than 400 characters"),
        ("a: [" + "1," * 100_000 + "]", ":1: here are more than 200000 keys, values and signs"),
        ("a: " + "9" * 5000, ":1: a number has more than 400 characters"),
        ("a: 2001-99-99", "not YAML"),
        ("#" * 1_000_001, "larger than 1000 kB"),
    ],
)
def test_what_would_take_endless_time_or_memory_is_refused(write, text, said):
    assert said in fault(write(text))


@dataclass
class Switch:
    live: bool = False


@pytest.mark.parametrize("text", ["live: 1", "live: 'true'", "live: []"])
def test_a_truth_value_is_true_or_false(write, text):
    path = write(f"\n{text}")
    with pytest.raises(WorkbenchError, match=r":2: live is .*, and should be true or false"):
        check_schema(read_yaml(path), Switch)
    check_schema(read_yaml(write("live: true")), Switch)


class ShoutLoader(yaml.SafeLoader):
    """Knows one tag more."""


ShoutLoader.add_constructor("!Shout", lambda loader, node: loader.construct_scalar(node).upper())


def test_a_tag_is_read_by_a_loader_that_knows_it(write):
    path = write("a: !Shout hey")
    assert read_yaml(path, ShoutLoader).data == {"a": "HEY"}
    assert "not YAML" in fault(path)


@pytest.mark.skipif(
    not hasattr(yaml, "CSafeLoader"), reason="PyYAML was built without libyaml: install its wheel"
)
def test_libyaml_reads_where_it_is_there():
    assert fast_loader() is yaml.CSafeLoader


@pytest.mark.parametrize("text", [TEXT, "a: &b 1", "a: {b: [1, .inf, 2001-01-01, ~, 'c']}"])
def test_both_loaders_read_the_same(write, text):
    path = write(text)
    assert read_yaml(path) == read_yaml(path, yaml.SafeLoader)


@dataclass
class Limits:
    limits: dict[str, float] = field(default_factory=dict)


@pytest.mark.parametrize(("key", "shown"), [("true", "True"), ("on", "True"), ("7", "7")])
def test_a_key_that_yaml_reads_as_something_else_is_named(write, key, shown):
    with pytest.raises(WorkbenchError, match=f":1: the key {shown} should be text"):
        check_schema(read_yaml(write(f"limits: {{{key}: 2.0}}")), Limits)
    check_schema(read_yaml(write(f"limits: {{'{key}': 2.0}}")), Limits)
