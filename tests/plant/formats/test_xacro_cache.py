"""Oracle: a process that starts is an expansion that was not kept."""

import pytest

from workbench.plant.formats import xacro as expander
from workbench.plant.formats.xacro import expand_xacro
from workbench.plant.packages import PackageFinder

HEAD = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
INNER = HEAD + '<xacro:property name="m" value="{}"/></robot>'
OUTER = HEAD + '<xacro:arg name="k" default="1"/><xacro:include filename="inner.xacro"/>{}</robot>'
MASS = "<m v=\"${m * int(xacro.arg('k'))}\"/>"


@pytest.fixture
def started(monkeypatch, tmp_path):
    """The requests that were expanded anew, with a cache of the test's own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    requests = []

    def noted(module, request, **limits):
        requests.append(request)
        return run_limited(module, request, **limits)

    run_limited = expander.run_limited
    monkeypatch.setattr(expander, "run_limited", noted)
    return requests


def expand(path, **args) -> str:
    return expand_xacro(path, args, PackageFinder(path))


def test_a_second_time_no_process_starts(write, started):
    write(INNER.format(3), "inner.xacro")
    path = write(OUTER.format(MASS), "outer.xacro")
    assert expand(path) == expand(path)
    assert '<m v="3"/>' in expand(path)
    assert len(started) == 1


def test_other_arguments_are_expanded_anew(write, started):
    write(INNER.format(3), "inner.xacro")
    path = write(OUTER.format(MASS), "outer.xacro")
    assert '<m v="3"/>' in expand(path)
    assert '<m v="6"/>' in expand(path, k="2")
    assert len(started) == 2


@pytest.mark.parametrize("changed", ["inner.xacro", "outer.xacro"])
def test_a_changed_file_is_expanded_anew(write, started, changed):
    write(INNER.format(3), "inner.xacro")
    path = write(OUTER.format(MASS), "outer.xacro")
    expand(path)
    if changed == "inner.xacro":
        write(INNER.format(4), changed)
    else:
        write(OUTER.format(MASS.replace("m *", "1 + m *")), changed)
    assert '<m v="4"/>' in expand(path)
    assert len(started) == 2


def test_a_data_file_that_an_expression_reads_counts(write, started):
    write("mass: 5\n", "data.yaml")
    text = HEAD + "<m v=\"${xacro.load_yaml('data.yaml')['mass']}\"/></robot>"
    path = write(text, "outer.xacro")
    assert '<m v="5"/>' in expand(path)
    write("mass: 7\n", "data.yaml")
    assert '<m v="7"/>' in expand(path)


@pytest.mark.parametrize(
    "text",
    [
        '<m v="$(optenv SOME_MASS 3)"/>',
        '<xacro:include filename="absent.xacro" optional="true"/>',
        '<xacro:include filename="part_*.xacro"/>',
    ],
)
def test_what_hangs_on_more_than_files_is_not_kept(write, started, text):
    write(HEAD + "</robot>", "part_1.xacro")
    path = write(HEAD + text + "</robot>", "outer.xacro")
    expand(path)
    expand(path)
    assert len(started) == 2


def test_a_cache_that_cannot_be_read_is_made_again(write, started, tmp_path):
    path = write(HEAD + "</robot>", "a.xacro")
    first = expand(path)
    (kept,) = (tmp_path / "cache").rglob("*.json")
    for broken in ("", "[]", '{"read": {}}'):
        kept.write_text(broken)
        assert expand(path) == first
    assert len(started) == 4


def test_where_nothing_can_be_written_it_works_all_the_same(write, started, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    path = write(HEAD + "</robot>", "a.xacro")
    assert expand(path) == expand(path)
