"""Descriptions that cannot be flown: each is a sentence that names the file."""

import re

import pytest
import xacro

from workbench.common.resources import find_model


@pytest.fixture(scope="module")
def urdf():
    return xacro.process_file(str(find_model("dh_drone"))).toxml()


XACRO = '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


def test_a_broken_description_is_named(case, refused, write, out, urdf):
    for pattern, replacement, word in [
        (
            '<link name="propeller1_link"',
            '<link name="other"',
            "the child link 'propeller1_link', which does not exist",
        ),
        (r'<mass value="[^"]*"', '<mass value="-1"', "mass -1"),
        (r'<mass value="[^"]*"', '<mass value="nan"', "give it numbers"),
        (r'ixx="[^"]*"', 'ixx="-5"', "negative moment of inertia"),
        (r'ixx="[^"]*"', 'ixx="much"', "give it numbers"),
        ("<motorConstant>[^<]*", "<motorConstant>-1", "motorConstant"),
        ("<motorNumber>0", "<motorNumber>first", "motorNumber"),
        ("<motorNumber>1", "<motorNumber>0", "motorNumber"),
        ("</robot>", "", "not XML"),
    ]:
        with case(pattern, replacement, word):
            path = write("drone.urdf", re.sub(pattern, replacement, urdf, count=1))
            sentence = refused("step", "--model", path, "--output", out)
            assert str(path) in sentence
            assert word in sentence
            assert not out.parent.exists()


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (XACRO.format('<link name="${nosuch}"/>'), "nosuch"),
        (XACRO.format('<xacro:include filename="gone.xacro"/>'), "gone.xacro"),
        (XACRO.format("<xacro:nosuch/>"), "nosuch"),
        (XACRO.format("<link"), ":1: not XML"),
        (XACRO.format('<link name="a"/>'), "no rotors"),
    ],
)
def test_a_broken_xacro_is_named(refused, write, out, text, word):
    path = write("drone.xacro", text)
    sentence = refused("step", "--model", path, "--output", out)
    assert str(path) in sentence
    assert word in sentence


def test_a_broken_file_spoils_nothing_for_the_next(refused, run, write, out):
    path = write("drone.xacro", XACRO.format('<xacro:include filename="gone.xacro"/>'))
    refused("step", "--model", path, "--output", out)
    assert (
        run("step", "--arg", "mass:=2", "--duration", "0.2", "--output", out, "--no-plots").code
        == 0
    )
