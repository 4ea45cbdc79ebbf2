"""Oracle: what xacro's own documentation says an argument and an include do."""

import pytest

from workbench.errors import WorkbenchError
from workbench.plant.xacro import expand_xacro

HEAD = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
WITH_ARG = HEAD + '<xacro:arg name="mass" default="3"/>\n<m v="${2*$(arg mass)}"/>\n</robot>'


def fault(path, **args) -> str:
    with pytest.raises(WorkbenchError) as caught:
        expand_xacro(path, args)
    return str(caught.value)


def test_an_argument_replaces_its_default(write):
    path = write(WITH_ARG, "a.xacro")
    assert '<m v="6"/>' in expand_xacro(path, {})
    assert '<m v="10"/>' in expand_xacro(path, {"mass": "5"})


def test_arguments_of_included_files_are_known(write):
    write(WITH_ARG, "inner.xacro")
    path = write(HEAD + '<xacro:include filename="inner.xacro"/></robot>', "outer.xacro")
    assert '<m v="14"/>' in expand_xacro(path, {"mass": "7"})


def test_an_argument_that_no_file_declares_is_refused(write):
    said = fault(write(WITH_ARG, "a.xacro"), mas="5")
    assert "a.xacro" in said
    assert "'mas': did you mean 'mass'?" in said


def test_broken_xml_is_named_with_its_line(write):
    path = write(HEAD + "<link>\n</robot>", "a.xacro")
    assert fault(path).startswith(f"{path}:3: ")


def test_a_broken_include_is_the_file_that_is_named(write, tmp_path):
    write(HEAD + '<m v="${nothing}"/></robot>', "inner.xacro")
    path = write(HEAD + '<xacro:include filename="inner.xacro"/></robot>', "outer.xacro")
    said = fault(path)
    assert said.startswith(str(tmp_path / "inner.xacro"))
    assert "nothing" in said


@pytest.mark.parametrize(
    ("body", "word"),
    [
        ("<xacro:include filename='gone.xacro'/>", "gone.xacro"),
        ("<xacro:wheel/>", "wheel"),
        ("<m v='${1/0}'/>", "division"),
        ("<m v='${no_such_name}'/>", "no_such_name"),
        ("${xacro.fatal('two\\nlines')}", "two lines"),
    ],
)
def test_any_fault_becomes_one_line_with_file_and_cause(write, body, word):
    path = write(HEAD + body + "</robot>", "a.xacro")
    said = fault(path)
    assert said.startswith(str(path))
    assert word in said
    assert "\n" not in said


def test_a_missing_file_is_named_even_after_another_fault(write, tmp_path):
    fault(write(HEAD + "<xacro:wheel/></robot>", "a.xacro"))
    assert fault(tmp_path / "gone.xacro").startswith(str(tmp_path / "gone.xacro"))
