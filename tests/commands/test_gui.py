"""`workbench gui`: what it refuses, before Qt is loaded."""

import socket
import struct
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from workbench.commands.cli import main
from workbench.commands.gui import check_display, check_libraries, x_server_listens
from workbench.common import system_libraries
from workbench.common.errors import WorkbenchError

REFUSED = [
    (("--scenario", "hoover"), "did you mean 'hover'"),
    (("--model", "dh_dron"), "did you mean 'dh_drone'"),
    (("--world", "rom"), "did you mean 'room'"),
    (("--gains", "nowhere.yaml"), "nowhere.yaml: no such file"),
    (("--screen", "tunning"), "did you mean 'tuning'"),
    (("--demo", "--scenario", "hover"), "give one of them"),
]


@pytest.mark.parametrize(("options", "words"), REFUSED)
def test_a_wrong_name_is_one_sentence(refused, options, words):
    assert words in refused("gui", *options)


def test_what_is_refused_loads_no_qt():
    code = (
        "import sys; from workbench.commands.cli import main; "
        "assert main(['gui', '--screen', 'nowhere']) == 2; "
        "assert not [name for name in sys.modules if name.startswith(('PyQt6', 'pydrake'))]"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_without_a_display_it_says_what_to_set(refused, monkeypatch):
    for name in ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    said = refused("gui")
    assert "there is no display" in said
    assert "QT_QPA_PLATFORM=offscreen" in said


def test_a_display_that_does_not_answer_is_refused(tmp_path):
    with pytest.raises(WorkbenchError, match="':417' does not answer"):
        check_display({"DISPLAY": ":417"})
    with pytest.raises(WorkbenchError, match="'wayland-9' does not answer"):
        check_display({"WAYLAND_DISPLAY": "wayland-9", "XDG_RUNTIME_DIR": str(tmp_path)})


def test_a_platform_of_the_user_s_is_trusted(tmp_path):
    unheard = {"DISPLAY": ":417", "XDG_RUNTIME_DIR": str(tmp_path)}
    for platform in ("offscreen", "wayland;offscreen", "vnc:size=800x600"):
        check_display({"QT_QPA_PLATFORM": platform} | unheard)
    egl = {"QT_QPA_PLATFORM": "wayland-egl"} | unheard
    check_display(egl | {"WAYLAND_SOCKET": "7"})
    with pytest.raises(WorkbenchError, match="'wayland-0' does not answer"):
        check_display(egl)


SYNC = struct.pack("=IHHI", 1, 0, 12, 2)
"""The request `wl_display.sync` for the object 2."""


@pytest.fixture
def compositor(tmp_path):
    """Let somebody listen at a socket, who answers with some bytes, and return the environment."""
    with socket.socket(socket.AF_UNIX) as listener, ThreadPoolExecutor(1) as threads:
        listener.bind(str(tmp_path / "wayland-0"))
        listener.listen()

        def answer(data):
            with listener.accept()[0] as end:
                heard = end.recv(12) if data else SYNC
                end.sendall(data)
            return heard

        def start(data):
            heard.append(threads.submit(answer, data))
            return {"XDG_RUNTIME_DIR": str(tmp_path)}

        heard = []
        yield start
        assert [each.result() for each in heard] == [SYNC] * len(heard)


DONE = struct.pack("=IHHI", 2, 0, 12, 0)
"""The event `wl_callback.done`."""


@pytest.mark.parametrize("more", [{"WAYLAND_DISPLAY": "wayland-0"}, {"QT_QPA_PLATFORM": "wayland"}])
def test_a_compositor_that_answers_is_used(compositor, more):
    check_display({**compositor(DONE), **more})


@pytest.mark.parametrize("more", [{"WAYLAND_DISPLAY": "wayland-0"}, {"QT_QPA_PLATFORM": "wayland"}])
def test_wayland_without_a_compositor_is_a_sentence(compositor, tmp_path, more):
    """Qt would end the process with SIGABRT."""
    with pytest.raises(WorkbenchError, match="'wayland-0' does not answer"):
        check_display({**compositor(b""), **more})
    (tmp_path / "dead").mkdir()
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(tmp_path / "dead" / "wayland-0"))  # the file stays when it is closed
    with pytest.raises(WorkbenchError, match="does not answer"):
        check_display({"XDG_RUNTIME_DIR": str(tmp_path / "dead"), **more})


def test_an_unknown_platform_is_a_sentence(refused, monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "ofscreen")
    said = refused("gui")
    assert "unknown platform of Qt 'ofscreen': did you mean 'offscreen'?" in said
    assert "QT_QPA_PLATFORM" in said


def test_an_x_server_on_the_network_is_reached():
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1] - 6000
        assert x_server_listens(f"127.0.0.1:{number}.0") == (number >= 0)
    assert not x_server_listens("nonsense")
    assert not x_server_listens(":")


def test_help_has_an_example(capsys):
    from workbench.commands.cli import main

    with pytest.raises(SystemExit) as ended:
        main(["gui", "--help"])
    assert ended.value.code == 0
    assert "workbench gui --scenario windy" in capsys.readouterr().out


def test_what_the_screen_needs_and_the_system_lacks_is_named(tmp_path, monkeypatch):
    """Qt aborts instead. What stands in for its plugin needs two libraries that nobody has."""
    plugins = tmp_path / "Qt6" / "plugins" / "platforms"
    plugins.mkdir(parents=True)
    (plugins / "libqxcb.so").touch()
    ldd = tmp_path / "ldd"
    ldd.write_text(
        "#!/bin/sh\n"
        "echo '\tlibxcb-cursor.so.0 => not found'\n"
        "echo '\tlibxcb-icccm.so.4 => not found'\n"
        "echo '\tlibc.so.6 => /lib/libc.so.6 (0x0)'\n"
    )
    ldd.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr(system_libraries, "package_folder", lambda _: tmp_path)
    with pytest.raises(WorkbenchError) as refusal:
        check_libraries({"DISPLAY": ":0"})
    said = str(refusal.value)
    assert "libxcb-cursor.so.0, libxcb-icccm.so.4" in said
    assert "sudo apt-get install libxcb-cursor0 libxcb-icccm4" in said
    assert "QT_QPA_PLATFORM=offscreen" in said
    check_libraries({"QT_QPA_PLATFORM": "offscreen"})  # whose plugin is not there


def test_arguments_of_a_xacro_file_are_given_as_elsewhere(monkeypatch, tmp_path):
    flown = []
    monkeypatch.setattr("workbench.gui.app.run", lambda choice, **_: flown.append(choice) or 0)
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    model = tmp_path / "mine.urdf.xacro"
    model.write_text("<robot/>")
    options = ["--arg", "mass:=1.25", "--arg", "name:=a b", "--package", f"mine={tmp_path}"]
    assert main(["gui", "--model", str(model), *options]) == 0
    assert (flown[0].model, flown[0].sensors) == (str(model), ("all",))
    vehicle = flown[0].load().vehicle
    assert vehicle.args == {"mass": "1.25", "name": "a b"}
    assert vehicle.packages == {"mine": str(tmp_path)}
    assert main(["gui", "--arg", "mass:=2"]) == 0
    assert flown[1].load().vehicle.args == {"mass": "2"}
    assert main(["gui", "--arg", "mass=2"]) == 2
