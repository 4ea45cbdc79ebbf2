"""Includes: where they are found, what of them is taken, and that they end."""

from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.plant.description import read_description
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

ARM = """<sdf version="1.9"><model name="arm">
  <pose>0 0 2 0 0 0</pose>
  <link name="hub"><sensor name="imu" type="imu"/></link>
  <frame name="mount"><pose>0 0 1 0 0 0</pose></frame>
  <plugin filename="inner" name="p"><linkName>hub</linkName></plugin>
</model></sdf>"""
CONFIG = '<model><name>arm</name><sdf version="{}">{}</sdf><sdf version="{}">{}</sdf></model>'


@pytest.fixture
def models(tmp_path) -> Path:
    """A folder of models: `arm` with a model.config."""
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm/model.sdf").write_text(ARM)
    (tmp_path / "arm/old.sdf").write_text("not SDF")
    (tmp_path / "arm/model.config").write_text(CONFIG.format("1.4", "old.sdf", "1.10", "model.sdf"))
    return tmp_path


def write(folder: Path, content: str, name: str = "top.sdf") -> Path:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(f'<sdf version="1.9">\n<model name="top">\n{content}\n</model>\n</sdf>')
    return path


def read(path: Path, **packages: Path) -> Model:
    return read_sdf(path, PackageFinder(path, packages), Remarks())


def fault(path: Path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(path)
    said = str(caught.value)
    assert "\n" not in said
    return said


def names(model: Model) -> list[str]:
    return [link.name for link in model.links]


MOTOR = """<plugin filename="gz-sim-multicopter-motor-model-system" name="motor">
  <jointName>{0}_joint</jointName><linkName>{0}</linkName></plugin>"""
LINK = '<link name="{}"><inertial><mass>1</mass><inertia/></inertial></link>'
JOINT = """<joint name="{1}_joint" type="{2}"><parent>{0}</parent><child>{1}</child></joint>"""
GIMBAL = '<include><uri>model://gimbal</uri></include><joint name="mount" type="fixed">'
GIMBAL += "<parent>body</parent><child>gimbal::arm</child></joint>"


def test_a_missing_include_without_rotors_is_a_remark(models):
    """All motors name what is here: the gimbal may be missing, and with it the joint to it."""
    spin = JOINT.format("body", "rotor", "revolute").replace("</joint>", "<axis/></joint>")
    drone = LINK.format("body") + LINK.format("rotor") + spin
    path = write(models, drone + GIMBAL + MOTOR.format("rotor"))
    remarks = Remarks()
    model = read_sdf(path, PackageFinder(path), remarks)
    assert names(model) == ["body", "rotor"]
    assert [joint.name for joint in model.joints] == ["rotor_joint"]
    said = [(remark.kind, remark.element) for remark in remarks.found]
    assert said == [("missing", "<include> of 'model://gimbal'"), ("ignored", "joint 'mount'")]
    assert "without it and its unknown mass" in remarks.found[0].text


@pytest.mark.parametrize(
    "content",
    [
        GIMBAL,  # there may be rotors in it
        GIMBAL + MOTOR.format("rotor"),  # here is one
        GIMBAL
        + LINK.format("rotor")
        + JOINT.format("body", "rotor", "revolute")
        + MOTOR.format("rotor")
        + '<frame name="f" attached_to="gimbal::arm"/>',  # what hangs on it cannot be placed
    ],
)
def test_a_missing_include_that_others_need_is_named(models, content):
    assert "<include> of 'model://gimbal' is not found" in fault(
        write(models, LINK.format("body") + content)
    )


@pytest.mark.parametrize(
    "uri",
    [
        "model://arm",
        "model://arm/model.sdf",
        "arm",
        "arm/model.sdf",
        "./arm",
        "{folder}/arm",
        "{folder}/arm/model.sdf",
        "file://{folder}/arm",
        " model://arm\n",
    ],
)
def test_a_model_is_found_by(models, uri):
    path = write(models, f"<include><uri>{uri.format(folder=models)}</uri></include>")
    model = read(path)
    assert names(model) == ["arm::hub"]
    assert model.links[0].X_ML.translation().tolist() == [0.0, 0.0, 2.0]


def test_a_relative_path_starts_at_the_file_that_says_it(models):
    write(models, "<include><uri>../arm</uri></include>", "inner/inner.sdf")
    path = write(models, "<include><uri>inner/inner.sdf</uri></include>")
    assert names(read(path)) == ["top::arm::hub"]


def test_a_folder_without_a_config_has_a_model_sdf(models):
    (models / "arm/model.config").unlink()
    assert names(read(write(models, "<include><uri>arm</uri></include>"))) == ["arm::hub"]


def test_a_model_online_is_taken_from_the_folder_that_was_given(models, tmp_path_factory):
    uri = "https://fuel.gazebosim.org/1.0/someone/models/Great%20Arm/4"
    path = write(tmp_path_factory.mktemp("other"), f"<include><uri>{uri}</uri></include>")
    assert names(read(path, **{"Great Arm": models / "arm"})) == ["arm::hub"]
    said = fault(path)
    assert said.startswith(f"{path}:3: <include> of 'https://fuel.gazebosim.org/")
    assert "on the internet" in said
    assert "--package 'Great Arm=DIR'" in said


def test_a_wrapper_of_a_model_online_does_not_include_itself(models):
    uri = "https://fuel.gazebosim.org/1.0/someone/models/arm"
    (models / "arm/model.sdf").write_text(
        f'<sdf version="1.9"><include><uri>{uri}</uri></include></sdf>'
    )
    assert "on the internet" in fault(models / "arm/model.sdf")


@pytest.mark.parametrize(
    ("uri", "name"),
    [
        ("model://leg", "leg"),
        ("leg/sub/leg.sdf", "leg"),
        ("../leg", "leg"),
        ("/no/where/leg", "leg"),
    ],
)
def test_a_missing_model_is_named_with_what_to_do(models, uri, name):
    path = write(models, f"<link name='a'/>\n<include><uri>{uri}</uri></include>")
    said = fault(path)
    assert said.startswith(f"{path}:4: <include> of '{uri}' is not found: ")
    assert f"--package {name}=DIR" in said


@pytest.mark.parametrize(
    "uri", ["", "model://", "/", "..", "x\0y".replace("\0", "&#1;"), "a" * 5000]
)
def test_a_uri_that_means_nothing_ends_with_a_sentence(models, uri):
    path = write(models, f"<include><uri>{uri}</uri></include>")
    assert len(fault(path)) < 500


def test_parts_of_an_include_have_its_name_in_front(models):
    path = write(
        models,
        "<include><uri>arm</uri><name>left</name><pose>1 0 0 0 0 0</pose></include>"
        "<include><uri>arm</uri><name>right</name>"
        "<pose>2 0 0 0 0 0</pose><placement_frame>mount</placement_frame></include>",
    )
    model = read(path)
    assert names(model) == ["left::hub", "right::hub"]
    assert model.links[0].X_ML.translation().tolist() == [1.0, 0.0, 0.0]
    assert model.links[1].X_ML.translation().tolist() == [2.0, 0.0, -1.0]
    assert [frame.link for frame in model.frames] == ["left::hub", "right::hub"]
    assert [sensor.link for sensor in model.sensors] == ["left::hub", "right::hub"]
    assert [plugin.findtext("linkName") for plugin in model.plugins] == [
        "left::hub",
        "right::hub",
    ]


def test_parts_of_a_merged_include_become_the_models_own(models):
    path = write(
        models,
        '<include merge="true"><uri>arm</uri><name>left</name></include><link name="body"/>'
        '<joint name="j" type="fixed"><parent>body</parent><child>hub</child></joint>',
    )
    model = read(path)
    assert model.name == "top"
    assert names(model) == ["hub", "body"]
    assert model.links[0].X_ML.translation().tolist() == [0.0, 0.0, 2.0]
    assert model.frames[0].name == "mount"
    (plugin,) = model.plugins
    (sensor,) = model.sensors
    assert plugin.findtext("linkName") == "hub"
    assert plugin.file == sensor.element.file == models / "arm/model.sdf"


@pytest.mark.parametrize("text", ["false", "0", ""])
def test_an_include_may_say_that_it_is_not_merged(models, text):
    path = write(models, f'<include merge="{text}"><uri>arm</uri></include>')
    assert names(read(path)) == ["arm::hub"]


def test_merge_is_yes_or_no(models):
    path = write(models, '<include merge="maybe"><uri>arm</uri></include>')
    assert "neither true nor false" in fault(path)


def test_two_merged_models_of_one_name_collide_only_in_their_parts(models):
    other = ARM.replace('"hub"', '"leg"').replace('"mount"', '"foot"')
    (models / "arm/other.sdf").write_text(other)
    path = write(
        models,
        '<include merge="1"><uri>arm</uri></include>'
        '<include merge="1"><uri>arm/other.sdf</uri><pose>1 0 0 0 0 0</pose></include>',
    )
    model = read(path)
    assert names(model) == ["hub", "leg"]
    assert model.links[1].X_ML.translation().tolist() == [1.0, 0.0, 0.0]
    twice = '<include merge="1"><uri>arm</uri></include>' * 2
    assert "two have the name 'hub'" in fault(write(models, twice))


def test_plugins_in_an_include_belong_to_the_included_model(models):
    plugin = '<plugin filename="outer" name="q"><linkName>hub</linkName></plugin>'
    path = write(models, f"<include><uri>arm</uri>{plugin}</include>")
    inner, outer = read(path).plugins
    assert inner.get("filename") == "inner"
    assert outer.get("filename") == "outer"
    assert outer.findtext("linkName") == "arm::hub"
    assert (inner.file, outer.file) == (models / "arm/model.sdf", path)
    merged = write(models, f"<include merge='true'><uri>arm</uri>{plugin}</include>")
    assert read(merged).plugins[1].findtext("linkName") == "hub"


def test_a_file_may_be_nothing_but_an_include(models):
    path = models / "alias.sdf"
    path.write_text(
        '<sdf version="1.9"><include><uri>arm</uri><name>alias</name>'
        "<pose>0 0 9 0 0 0</pose></include></sdf>"
    )
    model = read(path)
    assert model.name == "alias"
    assert model.links[0].name == "hub"
    assert model.links[0].X_ML.translation().tolist() == [0.0, 0.0, 0.0]
    outer = write(models, "<include><uri>alias.sdf</uri></include>")
    assert names(read(outer)) == ["alias::hub"]
    assert read(outer).links[0].X_ML.translation().tolist() == [0.0, 0.0, 9.0]


def test_a_fault_in_an_included_file_is_said_with_its_own_line(models):
    (models / "arm/model.sdf").write_text(ARM.replace("0 0 1 0 0 0", "0 0 1"))
    said = fault(write(models, "<include><uri>arm</uri></include>"))
    assert said.startswith(f"{models / 'arm/model.sdf'}:4: ")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('<robot name="r"><link name="l"/></robot>', "this is URDF (<robot>)"),
        ("<COLLADA/>", "the root element is <COLLADA>"),
        ('<sdf version="1.9"/>', "does not have exactly one <model>"),
        ('<sdf version="1.9"><world name="w"/></sdf>', "does not have exactly one <model>"),
        (
            '<sdf version="1.9"><model name="a"/><model name="b"/></sdf>',
            "does not have exactly one <model>",
        ),
        ("<sdf><model name='a'/></sdf>", "<sdf version=''>: give it the version"),
        ("<sdf version='new'><model name='a'/></sdf>", "<sdf version='new'>: give it the version"),
        ("<sdf version='1.2'><model name='a'/></sdf>", "SDF is read from version 1.3 on"),
        ("", "not XML"),
        ("<sdf version='1.9'><model name='arm'>", "not XML"),
    ],
)
def test_an_included_file_that_is_no_model_is_refused(models, text, said):
    (models / "arm/model.sdf").write_text(text)
    message = fault(write(models, "<include><uri>arm</uri></include>"))
    assert said in message
    assert str(models / "arm/model.sdf") in message


@pytest.mark.parametrize(
    ("template", "line"),
    [
        ("<sdf version='1.9'>\n{%- macro arm(x) -%}\n<model name='{{ x }}'/></sdf>", 2),
        ("<sdf version='1.9'>\n\n<model name={{ x }}/></sdf>", 3),
        ("<!-- {{ a }}\n\n -->\n<sdf version='1.9'>\n<model name='a<%= 1 %>'/></sdf>", 5),
    ],
)
@pytest.mark.parametrize("end", ["</sdf>", ""])
def test_a_template_is_to_be_rendered_first(tmp_path, template, line, end):
    path = tmp_path / "top.sdf"
    path.write_text(template.replace("</sdf>", end))
    said = fault(path)
    assert said.startswith(f"{path}:{line}: ")
    assert "render it first" in said


@pytest.mark.parametrize("suffix", [".urdf", ".xml"])
def test_a_template_of_another_format_is_refused_too(tmp_path, suffix):
    path = tmp_path / f"top{suffix}"
    path.write_text("<robot name='r'>\n<link name='{{ ns }}base'/></robot>")
    with pytest.raises(WorkbenchError, match=r":2: '{{ ns }}' makes this a template"):
        read_description(path)


def test_braces_that_do_not_close_are_those_of_a_name(tmp_path):
    path = tmp_path / "top.urdf"
    path.write_text("<robot name='r'><link name='wing{{1'/></robot>")
    assert read_description(path).base_link == "wing{{1"


def test_braces_in_comments_make_no_template(models):
    path = write(models, "<!-- made from {{ this }} --><link name='l'/><!-- {% -->")
    assert names(read(path)) == ["l"]


@pytest.mark.parametrize("version", ["1.3", "1.4", "1.9", "1.12", "1.12.1", "1.99"])
def test_versions_are_read(tmp_path, version):
    path = tmp_path / "top.sdf"
    path.write_text(f"<sdf version='{version}'><model name='a'><link name='l'/></model></sdf>")
    assert names(read(path)) == ["l"]


def test_a_config_that_leads_nowhere_is_named(models):
    (models / "arm/model.config").write_text(CONFIG.format("1.4", "old.sdf", "1.9", "gone.sdf"))
    said = fault(write(models, "<include><uri>arm</uri></include>"))
    assert "model.config" in said
    assert "gone.sdf" in said


def test_an_include_of_itself_ends(tmp_path):
    said = fault(write(tmp_path, "<include><uri>top.sdf</uri></include>"))
    assert "top.sdf:3: the file includes itself (top.sdf -> top.sdf)" in said


def test_includes_in_a_circle_end(tmp_path):
    write(tmp_path, "<include><uri>b.sdf</uri></include>", "a.sdf")
    write(tmp_path, "<include><uri>a.sdf</uri></include>", "b.sdf")
    said = fault(write(tmp_path, "<include><uri>a.sdf</uri></include>"))
    assert "(top.sdf -> a.sdf -> b.sdf -> a.sdf)" in said


def test_a_circle_through_links_of_the_file_system_ends(tmp_path):
    path = write(tmp_path, "<include><uri>other.sdf</uri></include>")
    (tmp_path / "other.sdf").symlink_to(path)
    assert "includes itself (top.sdf -> other.sdf)" in fault(path)


def test_includes_end_at_a_depth(tmp_path):
    for index in range(30):
        write(tmp_path, f"<include><uri>m{index + 1}.sdf</uri></include>", f"m{index}.sdf")
    assert "levels deep" in fault(tmp_path / "m0.sdf")


def test_a_chain_of_bare_includes_ends_at_a_depth(tmp_path):
    for index in range(30):
        (tmp_path / f"m{index}.sdf").write_text(
            f'<sdf version="1.9"><include><uri>m{index + 1}.sdf</uri></include></sdf>'
        )
    assert "levels deep" in fault(tmp_path / "m0.sdf")


def test_includes_that_multiply_end_at_a_number(tmp_path):
    for index in range(10):
        both = "".join(
            f"<include><name>{side}</name><uri>m{index + 1}.sdf</uri></include>" for side in "abc"
        )
        write(tmp_path, both, f"m{index}.sdf")
    write(tmp_path, '<link name="l"/>', "m10.sdf")
    assert "more than 200 includes" in fault(tmp_path / "m0.sdf")


def test_includes_of_large_files_end_at_a_size(tmp_path):
    filler = "<plugin>" + "<x/>" * 60_000 + "</plugin>"
    write(tmp_path, f'<link name="l"/>{filler}', "large.sdf")
    path = write(
        tmp_path,
        "".join(
            f"<include><name>m{index}</name><uri>large.sdf</uri></include>" for index in range(9)
        ),
    )
    assert "more than 200000 elements" in fault(path)
