"""Oracle: the circles as drawn here; Drake itself crashes on them."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.packages import PackageFinder
from workbench.plant.worlds.directive_includes import IncludeChecker

MODEL = """<sdf version="1.9"><model name="m"><link name="l"/>{}</model></sdf>"""

FILE_URI = "file://" + "/"


def model(*uris: str) -> str:
    return MODEL.format("".join(f"<include><uri>{uri}</uri></include>" for uri in uris))


@pytest.fixture
def check(tmp_path):
    """Check a file as a world beside it would."""

    def check_file(path, *, has_directives=False):
        finder = PackageFinder(tmp_path / "world.yaml", {"shed": tmp_path})
        IncludeChecker(finder).check(path, has_directives=has_directives)

    return check_file


@pytest.fixture
def fault(check):
    def say(path, **words) -> str:
        with pytest.raises(WorkbenchError) as caught:
            check(path, **words)
        return str(caught.value)

    return say


@pytest.mark.parametrize(
    "start", ["", "file://", "/", FILE_URI, "model://shed/", "package://shed/"]
)
def test_a_model_that_includes_itself_is_refused(fault, write, tmp_path, start):
    start = start.removesuffix("/") + f"{tmp_path}/" if start in ("/", FILE_URI) else start
    path = write(model(f"{start}box.sdf"), "box.sdf")
    assert fault(path) == f"{path}: includes itself: remove this include"


def test_a_circle_of_two_through_the_folder_of_a_model_is_refused(fault, write):
    write("<model><sdf version='1.9'>model.sdf</sdf></model>", "shed/model.config")
    write(model("other.sdf"), "shed/model.sdf")
    path = write(model("model://shed/shed"), "shed/other.sdf")
    assert fault(path).startswith(f"{path}: includes itself")


def test_the_working_directory_counts(fault, write, monkeypatch, tmp_path):
    """Drake looks for relative paths there."""
    write(model("sub.sdf"), "deep/er/box.sdf")
    path = write(model("sub.sdf"), "cwd/sub.sdf")
    monkeypatch.chdir(tmp_path / "cwd")
    assert fault(tmp_path / "deep/er/box.sdf").startswith(f"{path}: includes itself")


def test_directives_that_add_themselves_are_refused(fault, write):
    path = write("directives: [add_directives: {file: 'package://shed/a.yaml'}]", "a.yaml")
    assert fault(path, has_directives=True).startswith(f"{path}: includes itself")


def test_a_model_that_directives_add_is_walked(fault, write):
    path = write(model("box.sdf"), "box.sdf")
    more = write("directives: [add_model: {name: a, file: 'package://shed/box.sdf'}]", "a.yaml")
    assert fault(more, has_directives=True).startswith(f"{path}: includes itself")


@pytest.mark.parametrize("name", ["a.xml", "a.XML"])
def test_a_model_of_mujocos_is_refused(fault, write, name):
    path = write("<mujoco/>", name)
    assert fault(path) == f"{path}: is a MuJoCo model: give it as SDF or URDF"
    assert fault(write(model(name), "box.sdf")).startswith(f"{path}: is a MuJoCo model")


def test_a_chain_is_no_deeper_than_twenty(check, fault, write):
    paths = [write(model(f"{index + 1}.sdf"), f"{index}.sdf") for index in range(21)]
    last = write(model(), "21.sdf")
    check(paths[1])
    assert fault(paths[0]).startswith(f"{last}: is included more than 20 deep")


def test_what_is_included_twice_is_counted_twice(check, fault, write):
    paths = [write(model(*[f"{index + 1}.sdf"] * 2), f"{index}.sdf") for index in range(10)]
    write(model(), "10.sdf")
    check(paths[2])  # 511 files
    assert "with this one, more than 1000 files are included" in fault(paths[0])


@pytest.mark.parametrize("uri", ["gone.sdf", "model://gone", "https://example.org/a", ""])
def test_what_is_not_found_is_left_to_drake(check, write, uri):
    check(write(model(uri), "box.sdf"))


def test_a_model_may_be_included_twice(check, write):
    write(model(), "leaf.sdf")
    check(write(model("leaf.sdf", "leaf.sdf"), "box.sdf"))
