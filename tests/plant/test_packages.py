"""Oracle: where ROS, ament and Gazebo say that packages and models lie."""

import os
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant import packages
from workbench.plant.packages import PackageFinder

VARIABLES = (
    "ROS_PACKAGE_PATH",
    "AMENT_PREFIX_PATH",
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
)


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)


@pytest.fixture
def make(tmp_path):
    """Make files in a folder of the test, named as `path` or `path=text`; return the first."""

    def make_files(*files: str) -> Path:
        for file in files:
            name, _, text = file.partition("=")
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path / files[0].partition("=")[0]

    return make_files


def package(folder: str, name: str) -> str:
    return f"{folder}/package.xml=<package><name>\n {name} </name></package>"


def found(path: Path | None, top: Path) -> str | None:
    return path and os.path.normpath(path.relative_to(top))


@pytest.mark.parametrize(
    ("files", "folder"),
    [
        pytest.param([package("ws/renamed", "drone")], "ws/renamed", id="package.xml above"),
        pytest.param(["ws/drone/model.config"], "ws/drone", id="model beside"),
        pytest.param(["ws/renamed/drone/model.sdf"], "ws/renamed/drone", id="model below"),
        pytest.param(["drone/any.txt"], "drone", id="mere namesake above"),
        pytest.param([package("ws/other", "drone")], "ws/other", id="neighbour that says so"),
        pytest.param([package("other", "drone")], None, id="a far neighbour"),
        pytest.param(
            [package("ws/renamed", "drone"), "ws/renamed/urdf/drone/a"], "ws/renamed", id="says so"
        ),
        pytest.param(
            ["drone/model.config", "ws/drone/model.config"], "ws/drone", id="nearest of two"
        ),
        pytest.param(["ws/drone/package.xml=<broken"], "ws/drone", id="broken package.xml"),
        pytest.param(["ws/.git/HEAD", package("ws/a/b/c", "drone")], "ws/a/b/c", id="repository"),
        pytest.param(["ws/Drone/model.config"], None, id="other case"),
        pytest.param([package("ws/a/b", "drone")], None, id="a cousin, and no repository"),
        pytest.param([package("ws/.hidden", "drone")], None, id="hidden"),
    ],
)
def test_a_name_is_looked_for_above_and_beside_the_description(make, tmp_path, files, folder):
    source = make("ws/renamed/urdf/a.urdf", *files)
    assert found(PackageFinder(source).folder("drone"), tmp_path) == folder


def test_a_folder_goes_before_its_namesake_inside(make, tmp_path):
    source = make("drone/urdf/a.urdf", "drone/drone/node.py")
    assert PackageFinder(source).folder("drone") == tmp_path / "drone"


def test_it_is_looked_for_around_what_a_link_leads_to(make, tmp_path):
    target = make("ws/urdf/a.urdf", package("ws", "drone"))
    link = make("elsewhere/deep/down/here/b.txt").with_name("a.urdf")
    link.symlink_to(target)
    assert PackageFinder(link).folder("drone") == tmp_path / "ws"


@pytest.mark.parametrize(
    ("variable", "value", "file", "folder"),
    [
        ("ROS_PACKAGE_PATH", "env", package("env/repo/group/x", "drone"), "env/repo/group/x"),
        ("ROS_PACKAGE_PATH", "env/x", package("env/x", "drone"), "env/x"),
        ("ROS_PACKAGE_PATH", "env", package("env/a/b/c/d/e/f", "drone"), None),
        ("AMENT_PREFIX_PATH", "env", "env/share/drone/package.xml", "env/share/drone"),
        *((name, "env", "env/drone/model.sdf", "env/drone") for name in VARIABLES[2:]),
        *((name, "env/drone", "env/drone/model.sdf", "env/drone") for name in VARIABLES[2:]),
        ("GZ_SIM_RESOURCE_PATH", "env", "env/a/drone/model.sdf", None),
    ],
)
def test_a_name_is_looked_for_through_the_environment(
    make, tmp_path, monkeypatch, variable, value, file, folder
):
    source = make("a/b/c/d/e/a.urdf", file)
    gone = tmp_path / "gone"
    monkeypatch.setenv(variable, f"{gone}{os.pathsep}{os.pathsep}{tmp_path / value}")
    assert found(PackageFinder(source).folder("drone"), tmp_path) == folder


def test_what_is_near_goes_before_the_environment(make, tmp_path, monkeypatch):
    source = make("ws/drone/a.urdf", package("env/drone", "drone"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "env"))
    assert PackageFinder(source).folder("drone") == tmp_path / "ws" / "drone"


def test_folders_that_lead_in_a_circle_are_walked_once(make, tmp_path, monkeypatch):
    deep = "env/x/x/x/x/x/x/x/x/x/x/x/x"
    source = make("a/b/c/d/a.urdf", package(deep, "drone"))
    for name in ("loop", "other_loop"):  # 2¹² ways down, more than are walked
        (tmp_path / "env" / name).symlink_to(tmp_path / "env")
    monkeypatch.setattr(packages, "_PACKAGE_SEARCH_DEPTH", 10**9)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "env"))
    assert PackageFinder(source).folder("drone") == tmp_path / deep


def test_the_walk_ends_after_so_many_folders(make, tmp_path, monkeypatch):
    names = [f"env/a{i}/b.txt" for i in range(20)]
    source = make("a/b/c/d/a.urdf", *names, package("env/z", "drone"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "env"))
    monkeypatch.setattr(packages, "_MAX_SEARCHED_FOLDERS", 10)
    assert PackageFinder(source).folder("drone") is None


@pytest.mark.parametrize("home", ["env", "env/x"])
def test_a_home_folder_and_what_is_above_are_not_searched_deeply(make, tmp_path, monkeypatch, home):
    source = make("a/b/c/d/a.urdf", package("env/x/y", "deep"), package("env/x", "shallow"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "env"))
    monkeypatch.setenv("HOME", str(tmp_path / home))
    assert PackageFinder(source).folder("deep") is None
    assert PackageFinder(source).folder("shallow") == tmp_path / "env" / "x"


def test_after_a_thousand_names_no_more_are_looked_for(make, monkeypatch):
    finder = PackageFinder(make("ws/a.urdf", "ws/drone/model.sdf"))
    monkeypatch.setattr(packages, "_MAX_NAMED_PACKAGES", 2)
    assert [finder.folder(name) for name in ("a", "b", "drone")] == [None, None, None]


def test_a_given_folder_goes_before_all_others(make, tmp_path, monkeypatch):
    source = make("drone/a.urdf", package("drone", "drone"), "given/b.stl")
    monkeypatch.chdir(tmp_path)
    finder = PackageFinder(source, {"drone": "given"})
    assert finder.folder("drone") == tmp_path / "given"
    assert finder.resolve("package://drone/b.stl", source) == tmp_path / "given" / "b.stl"
    assert finder.resolve("package://drone/a.urdf", source) is None


@pytest.mark.parametrize("folder", ["gone", "a.urdf", "~nobody/at/all", "a" * 5000, "\0"])
def test_a_given_folder_that_is_none_is_refused(make, tmp_path, monkeypatch, folder):
    source = make("a.urdf")
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(WorkbenchError, match="package 'drone'.*--package drone=DIR"):
        PackageFinder(source, {"drone": folder})


@pytest.mark.parametrize(
    ("uri", "file"),
    [
        ("package://drone/meshes/a.dae", "ws/drone/meshes/a.dae"),
        ("model://drone/meshes/a.dae", "ws/drone/meshes/a.dae"),
        (" package://drone/meshes/a.dae\n", "ws/drone/meshes/a.dae"),
        ("package://drone//meshes/a.dae", "ws/drone/meshes/a.dae"),
        ("package://drone/meshes/with%20space.dae", "ws/drone/meshes/with space.dae"),
        ("package://drone/meshes/with space.dae", "ws/drone/meshes/with space.dae"),
        ("package://drone/meshes/100%25.dae", "ws/drone/meshes/100%25.dae"),
        ("model://drone", "ws/drone"),
        ("package://drone/", "ws/drone"),
        ("package://drone/../other/b.dae", "ws/other/b.dae"),
        ("model://other/b.dae", "ws/other/b.dae"),
        ("file://other/b.dae", "ws/other/b.dae"),
        ("other/b.dae", "ws/other/b.dae"),
        ("file://{top}/ws/other/b.dae", "ws/other/b.dae"),
        ("{top}/ws/other/b.dae", "ws/other/b.dae"),
        ("near.dae", "ws/drone/parts/near.dae"),
        ("../meshes/a.dae", "ws/drone/meshes/a.dae"),
        ("source.dae", "ws/drone/urdf/source.dae"),
        ("in_env.dae", "env/in_env.dae"),
        ("model://in_env/c.dae", "env/in_env/c.dae"),
        ("package://unknown/meshes/a.dae", "ws/drone/meshes/a.dae"),
        ("model://unknown/near.dae", "ws/drone/parts/near.dae"),
    ],
)
def test_a_uri_is_the_file_that_it_means(make, tmp_path, monkeypatch, uri, file):
    source = make(
        "ws/drone/urdf/a.urdf",
        package("ws/drone", "drone"),
        "ws/drone/meshes/a.dae",
        "ws/drone/meshes/with space.dae",
        "ws/drone/meshes/100%25.dae",
        "ws/drone/parts/near.dae",
        "ws/drone/urdf/source.dae",
        "ws/other/b.dae",
        "ws/other/model.config",
        "env/in_env.dae",
        "env/in_env/c.dae",
    )
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(tmp_path / "env"))
    path = PackageFinder(source).resolve(
        uri.format(top=tmp_path), tmp_path / "ws/drone/parts/b.urdf"
    )
    assert found(path, tmp_path) == file


@pytest.mark.parametrize(
    "uri",
    [
        "",
        " ",
        ".",
        "/",
        "a" * 5000,
        "\0",
        "a\0b",
        "%00",
        "\udcff\ud800",
        "package://",
        "package:///",
        "package://..",
        "package://.",
        "package://unknown",
        "package://a\0/b",
        "package://" + "a" * 5000 + "/b",
        "model://drone/gone.dae",
        "package://drone/A.URDF",
        "http://example.org/ws/drone/a.urdf",
        "https://example.org/a.urdf",
        "fuel://drone/a.urdf",
        "://drone/a.urdf",
        "file://",
        "gone.dae",
        "gone/gone.dae",
        "/gone/for/good.dae",
        "/dev/zero",
        "file://" + "/dev/zero",
        "package://drone/pipe",
    ],
)
def test_what_is_not_there_is_none(make, uri):
    source = make("ws/drone/a.urdf", package("ws/drone", "drone"))
    os.mkfifo(source.with_name("pipe"))
    assert PackageFinder(source).resolve(uri, source) is None


@pytest.mark.parametrize(
    ("source", "marks", "reached", "beyond"),
    [
        pytest.param("a/b/x.urdf", [], "a/b/c/d.stl", "a/d.stl", id="its folder"),
        pytest.param("a/urdf/x.urdf", [], "a/meshes/d.stl", "d.stl", id="the drone's folder"),
        pytest.param("a/b/x.urdf", ["a/package.xml"], "a/c/d.stl", "d.stl", id="its package"),
        pytest.param("a/b/x.urdf", ["a/.git/HEAD"], "a/c/d.stl", "d.stl", id="its repository"),
        pytest.param(
            "a/b/x.urdf", [package("c/d", "n")], "a/b/d.stl", "c/d/e.stl", id="far package"
        ),
        pytest.param("a/b/x.urdf", [package("a/c", "n")], "a/c/d.stl", "a/e/d.stl", id="neighbour"),
        pytest.param("a/b/x.urdf", ["env/e"], "env/d.stl", "env2/d.stl", id="environment"),
        pytest.param("a/b/x.urdf", ["given/e"], "given/d.stl", "a/given/d.stl", id="given"),
        pytest.param("home/x.urdf", [], "home/d.stl", "home/.d.stl", id="home, hidden file"),
        pytest.param("home/x.urdf", [], "home/d.stl", "home/.ssh/d.stl", id="home, hidden folder"),
        pytest.param("home/x.urdf", ["home/.git/HEAD"], "home/d.stl", "home/a/d.stl", id="home"),
    ],
)
@pytest.mark.parametrize("link", [False, True])
def test_a_description_is_given_its_own_files_and_those_of_packages(
    make, tmp_path, monkeypatch, source, marks, reached, beyond, link
):
    """By path, by a path that climbs, and by a link that leads out of its folder."""
    path = make(source, *marks, reached, beyond, "given/e")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(tmp_path / "env"))
    finder = PackageFinder(path, {"n": tmp_path / "given"} if "given/e" in marks else {})
    for file, is_found in ((reached, True), (beyond, False)):
        names = [str(tmp_path / file), os.path.relpath(tmp_path / file, path.parent)]
        if link:
            path.with_name(f"link{is_found}.stl").symlink_to(tmp_path / file)
            names = [f"link{is_found}.stl"]
        for name in (*names, f"file://{names[0]}"):
            assert bool(finder.resolve(name, path)) == is_found, name


@pytest.mark.parametrize("name", ["etc", ".ssh", "home", "private"])
def test_a_folder_of_the_machine_or_a_user_is_no_package(make, tmp_path, monkeypatch, name):
    source = make("home/a/x.urdf", "home/.ssh/id", "home/private/id", "home/a/.ssh/id")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert PackageFinder(source).folder(name) is None


def test_a_missing_file_of_a_known_package_is_not_taken_from_another(make):
    source = make("ws/drone/urdf/a.urdf", package("ws/other", "other"), "ws/drone/meshes/a.dae")
    assert PackageFinder(source).resolve("package://other/meshes/a.dae", source) is None


def test_a_relative_source_is_looked_around_too(make, tmp_path, monkeypatch):
    make("ws/urdf/a.urdf", package("ws", "drone"), "ws/b.stl")
    monkeypatch.chdir(tmp_path / "ws")
    source = Path("urdf/a.urdf")
    assert PackageFinder(source).resolve("package://drone/b.stl", source) == tmp_path / "ws/b.stl"


def test_the_hint_says_what_to_type(make):
    assert PackageFinder(make("a.urdf")).hint("drone") == "give --package drone=DIR"
