"""Oracle: what xacro's own documentation says an argument and an include do."""

import os
import sys
from pathlib import Path
from types import ModuleType

import pytest
import xacro

from workbench.common.errors import WorkbenchError
from workbench.plant.formats import xacro as ours
from workbench.plant.formats.xacro import expand_xacro
from workbench.plant.packages import PackageFinder

PUBLISHED = Path(__file__).parents[3] / "../shared/models/rotors_description/urdf"
HEAD = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
WITH_ARG = HEAD + '<xacro:arg name="mass" default="3"/>\n<m v="${2*$(arg mass)}"/>\n</robot>'
BOMB = """<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<robot name="&b;"/>"""


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH"):
        monkeypatch.delenv(name, raising=False)


def expand(path: Path, **args: str) -> str:
    return expand_xacro(path, args, PackageFinder(path))


def fault(path: Path, **args: str) -> str:
    with pytest.raises(WorkbenchError) as caught:
        expand(path, **args)
    said = str(caught.value)
    assert "\n" not in said
    assert len(said) < 2000
    return said


def include(filename: str) -> str:
    return f'{HEAD}<xacro:include filename="{filename}"/></robot>'


def test_an_argument_replaces_its_default(write):
    path = write(WITH_ARG, "a.xacro")
    assert '<m v="6"/>' in expand(path)
    assert '<m v="10"/>' in expand(path, mass="5")


def test_arguments_of_included_files_are_known(write):
    write(WITH_ARG, "inner.xacro")
    path = write(include("inner.xacro"), "outer.xacro")
    assert '<m v="14"/>' in expand(path, mass="7")


def test_an_argument_that_no_file_declares_is_refused(write):
    said = fault(write(WITH_ARG, "a.xacro"), mas="5")
    assert "a.xacro" in said
    assert "'mas': did you mean 'mass'?" in said


def test_an_argument_for_a_file_that_takes_none_is_refused(write):
    path = write(HEAD + "</robot>", "a.xacro")
    assert fault(path, mass="5") == f"{path}: takes no arguments, but 'mass' was given"


def test_an_argument_that_is_only_used_or_declared_without_default_is_known(write):
    bare = '<xacro:arg name="bare"/><m v="$(arg bare)"/>'
    unread = '<xacro:if value="false"><m v="$(arg unread)"/></xacro:if>'
    path = write(HEAD + bare + unread + '<n v="$(arg used)"/></robot>', "a.xacro")
    assert '<m v="1"/><n v="2"/>' in expand(path, bare="1", used="2", unread="3")


def test_all_arguments_without_a_default_are_named_at_once(write):
    inner = """<xacro:if value="$(arg b)"><m v="$(arg c)"/></xacro:if>
    <xacro:unless value="$(arg b)">
      <m v="${xacro.arg('d') + xacro.arg(&quot;e&quot;)}"/>
    </xacro:unless>
    <xacro:arg name="has_default" default="$(arg in_default)"/><m v="$(arg has_default)"/>
    <xacro:macro name="never_called"><m v="$(arg in_macro)"/></xacro:macro>
    <!-- $(arg in_comment) -->"""
    write(f"{HEAD}{inner}</robot>", "inner.xacro")
    outer = '<m v="$(arg a) $(arg given)"/><xacro:include filename="inner.xacro"/><xacro:arg '
    path = write(HEAD + outer + 'name="bare"/><m v="${1/0}"/></robot>', "outer.xacro")
    said = fault(path, given="1")
    start, _, listed = said.partition(": has arguments without a default: give ")
    assert start == str(path)
    names = ["a", "b", "bare", "c", "d", "e", "in_default", "in_macro"]
    assert sorted(listed.replace("--arg ", "").split()) == [f"{name}:=…" for name in names]
    assert listed.startswith("--arg a:=… ")


def test_an_argument_with_a_computed_name_is_named(write):
    text = '<xacro:property name="p" value="front"/><m v="$(arg mass_${p})"/></robot>'
    path = write(HEAD + text, "a.xacro")
    assert fault(path).endswith("give --arg mass_front:=…")
    assert '<m v="2"/>' in expand(path, mass_front="2")


def test_an_argument_used_before_its_default_is_named(write):
    text = '<m v="$(arg late)"/><xacro:arg name="late" default="1"/></robot>'
    assert fault(write(HEAD + text, "a.xacro")).endswith("give --arg late:=…")


def test_a_misspelt_argument_is_said_before_the_one_that_lacks(write):
    path = write(HEAD + '<m v="$(arg namespace)"/></robot>', "a.xacro")
    assert "'namespac': did you mean 'namespace'?" in fault(path, namespac="a")


def test_broken_xml_is_named_with_its_line(write):
    path = write(HEAD + "<link>\n</robot>", "a.xacro")
    assert fault(path).startswith(f"{path}:3: ")


def test_a_broken_include_is_the_file_that_is_named(write, tmp_path):
    write(HEAD + '<m v="${nothing}"/></robot>', "inner.xacro")
    said = fault(write(include("inner.xacro"), "outer.xacro"))
    assert said.startswith(str(tmp_path / "inner.xacro"))
    assert "nothing" in said


@pytest.mark.parametrize(
    ("body", "word"),
    [
        ("<xacro:include filename='gone.xacro'/>", "gone.xacro"),
        ("<xacro:wheel/>", "wheel"),
        ("<m v='${1/0}'/>", "division"),
        ("<m v='${1/0}'/>", "'1/0'"),
        ("<m v='${no_such_name}'/>", "no_such_name"),
        ("<m v=\"${dict(a=1)['b']}\"/>", "there is no 'b'"),
        ("${xacro.fatal('two\\nlines')}", "two lines"),
        ("<m v='$(env NO_SUCH_VARIABLE)'/>", "NO_SUCH_VARIABLE"),
        ("<m v='$(find no_such)'/>", "package 'no_such' is not found"),
        ("<m v='$(find no_such)'/>", "give --package no_such=DIR"),
    ],
)
def test_any_fault_becomes_one_line_with_file_and_cause(write, body, word):
    path = write(HEAD + body + "</robot>", "a.xacro")
    said = fault(path)
    assert said.startswith(f"{path}: ")
    assert word in said


def test_a_missing_file_is_named(tmp_path):
    assert fault(tmp_path / "gone.xacro") == f"{tmp_path / 'gone.xacro'}: no such file"


def test_an_include_may_be_optional(write):
    text = '<xacro:include filename="gone.xacro" optional="true"/><m/></robot>'
    assert "<m/>" in expand(write(HEAD + text, "a.xacro"))


def test_the_environment_and_yaml_files_are_read_as_xacro_does(write, monkeypatch):
    monkeypatch.setenv("DRONE_MASS", "7")
    write("mass: 2", "mass.yaml")
    text = "<m v=\"$(env DRONE_MASS) ${xacro.load_yaml('mass.yaml').mass}\"/></robot>"
    assert '<m v="7 2"/>' in expand(write(HEAD + text, "a.xacro"))


def test_letters_of_any_language_come_through(write):
    text = "<m v=\"${'größe'} 無人機\"/></robot>"
    assert '<m v="größe 無人機"/>' in expand(write(HEAD + text, "a.xacro"))


def test_warnings_do_not_reach_the_terminal(write, capfd):
    text = "<m v=\"${xacro.warning('mind')} ${sorted([2, 1])}\"/></robot>"
    assert '<m v=" [1, 2]"/>' in expand(write(HEAD + text, "a.xacro"))
    assert capfd.readouterr() == ("", "")


def test_a_package_is_found_by_the_package_xml_above(tmp_path):
    inner = tmp_path / "renamed" / "parts" / "inner.xacro"
    outer = tmp_path / "renamed" / "urdf" / "outer.xacro"
    for path in (inner, outer):
        path.parent.mkdir(parents=True)
    (tmp_path / "renamed" / "package.xml").write_text("<package><name>drone</name></package>")
    inner.write_text(HEAD + '<m v="$(find drone)/mesh"/></robot>')
    outer.write_text(include("$(find drone)/parts/inner.xacro"))
    assert f'<m v="{tmp_path}/renamed/mesh"/>' in expand(outer)


def test_a_package_is_guessed_by_a_file_that_it_must_have(tmp_path):
    """A folder that was taken out of its package has no package.xml any more."""
    outer = tmp_path / "urdf" / "outer.xacro"
    (tmp_path / "urdf" / "parts").mkdir(parents=True)
    (tmp_path / "urdf" / "parts" / "inner.xacro").write_text(HEAD + "<m/></robot>")
    mesh = '<n v="$(find drone)/meshes/a.dae"/></robot>'
    outer.write_text(include("$(find drone)/urdf/parts/inner.xacro").replace("</robot>", mesh))
    assert f'<m/><n v="{tmp_path}/meshes/a.dae"/>' in expand(outer)


def test_a_given_package_is_used(write, tmp_path):
    (tmp_path / "given").mkdir()
    path = write(HEAD + '<m v="$(find drone)"/></robot>', "a.xacro")
    text = expand_xacro(path, {}, PackageFinder(path, {"drone": tmp_path / "given"}))
    assert f'<m v="{tmp_path}/given"/>' in text


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("<xacro:include filename='a.xacro'/>", "let no file include itself"),
        ("<xacro:include filename='../{folder}/a.xacro'/>", "let no file include itself"),
        ("<xacro:include filename='b.xacro'/>", "a.xacro -> b.xacro"),
        ("<xacro:include filename='bomb.xacro'/>", "bomb.xacro:1: it declares its own entities"),
        ("<xacro:include filename='pipe'/>", "is a pipe or a device"),
        ("<xacro:include filename='{long}'/>", "name too long"),
        ("<xacro:macro name='f'><xacro:f/></xacro:macro><xacro:f/>", "nested too deeply"),
        ("<xacro:property name='p' value='${{p}}'/><m v='${{p}}'/>", "circular"),
        ("<m v=\"${{'a'*10**11}}\"/>", "not enough memory"),
        ('<m v="${{[0]*10**12}}"/>', "not enough memory"),
        ("<m v=\"${{'a'*16*10**6}}\"/>", "more than 16 MB"),
        ("<m v='${{9**9**9}}'/>", "a power of more than 100,000 bits is too large"),
        ("<m v='${{" + "(" * 5000 + ")" * 5000 + "}}'/>", "too many nested parentheses"),
    ],
)
def test_what_would_never_end_or_fit_ends_with_a_sentence(write, tmp_path, body, said):
    write(include("a.xacro"), "b.xacro")
    write(BOMB, "bomb.xacro")
    os.mkfifo(tmp_path / "pipe")
    text = body.format(folder=tmp_path.name, long="a" * 5000)
    assert said in fault(write(f"{HEAD}{text}</robot>", "a.xacro"))


TWICE = '<xacro:f n="${n-1}"/><xacro:f n="${n-1}"/>'
DOUBLING = (
    f'<xacro:macro name="f" params="n"><m/><xacro:if value="${{n>0}}">{TWICE}</xacro:if>'
    '</xacro:macro><xacro:f n="40"/>'
)


@pytest.mark.parametrize(
    "body",
    [
        "<m v='${max([i - i for i in range(10**9)])}'/>",
        pytest.param(DOUBLING, marks=pytest.mark.slow),
    ],
)
def test_what_takes_too_long_is_stopped(write, monkeypatch, body):
    monkeypatch.setattr(ours, "_XACRO_CPU_S", 1.0)
    path = write(f"{HEAD}{body}</robot>", "a.xacro")
    assert fault(path).startswith(f"{path}: cannot be expanded: it took more than 1 s")


def test_entities_are_refused_in_the_file_itself(write):
    path = write(BOMB, "a.xacro")
    assert fault(path).startswith(f"{path}:1: it declares its own entities")


def _descriptions():
    """Yield complete descriptions, here and published, with the arguments that they need."""
    here = Path(__file__).parents[3]
    paths = [
        *(here / "models").rglob("*.urdf.xacro"),
        *(here / "tests/drones").glob("*.urdf.xacro"),
    ]
    for path in sorted(paths):
        yield pytest.param(path, {}, id=path.name)
    bird = {"namespace": "bird"} | dict.fromkeys(
        ("enable_mavlink_interface", "enable_logging", "wait_to_record_bag"), "true"
    )
    base = {"enable_ground_truth": "true", "log_file": "log"}
    absent = pytest.mark.skipif(
        not PUBLISHED.is_dir(), reason=f"not tested: put them in {PUBLISHED}"
    )
    for name, args in (
        ("hummingbird.xacro", {"namespace": "bird"}),
        ("hummingbird_base.xacro", {**bird, **base}),
    ):
        yield pytest.param(PUBLISHED / name, args, id=name, marks=absent)


@pytest.mark.parametrize(("path", "args"), list(_descriptions()))
def test_a_description_becomes_what_xacro_makes_of_it(path, args, monkeypatch, capfd):
    """To the byte, with Python's own evaluation in xacro."""
    finder = PackageFinder(path)
    ros = ModuleType("ament_index_python.packages")
    ros.get_package_share_directory = lambda name: str(finder.folder(name))
    monkeypatch.setitem(sys.modules, "ament_index_python", ModuleType("ament_index_python"))
    monkeypatch.setitem(sys.modules, "ament_index_python.packages", ros)
    for state in ("filestack", "macrostack"):
        monkeypatch.setattr(xacro, state, None)
    expected = xacro.process_file(str(path), mappings=dict(args)).toxml()
    assert expand(path, **args) == expected


@pytest.mark.skipif(
    not PUBLISHED.is_dir(),
    reason="put the published descriptions into ../shared/models to try them",
)
def test_published_descriptions_expand_as_they_are():
    text = expand(PUBLISHED / "hummingbird.xacro", namespace="bird")
    assert text.count("<joint ") == 5
    assert '<link name="bird/base_link"' in text
    said = fault(PUBLISHED / "hummingbird.xacro")
    assert said.endswith(".xacro: has arguments without a default: give --arg namespace:=…")


@pytest.mark.skipif(
    not PUBLISHED.is_dir(),
    reason="put the published descriptions into ../shared/models to try them",
)
def test_all_arguments_of_a_published_description_are_named():
    listed = fault(PUBLISHED / "hummingbird_base.xacro").partition(": give ")[2].split()
    assert set(listed) - {"--arg"} == {
        "namespace:=…",
        "enable_logging:=…",
        "enable_ground_truth:=…",
        "enable_mavlink_interface:=…",
        "log_file:=…",
        "wait_to_record_bag:=…",
    }
