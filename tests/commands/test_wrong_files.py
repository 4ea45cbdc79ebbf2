"""Whatever is named where a file belongs, every command ends with a sentence, and soon."""

import os

import pytest

READERS = (
    ["inspect", "{}"],
    ["params", "--model", "{}"],
    ["params", "--gains", "{}"],
    ["params", "--rotors", "{}"],
    ["step", "--world", "{}"],
    ["fly", "{}"],
    ["fly", "--rotor-commands", "{}"],
    ["frames", "--scenario", "{}"],
    ["replay", "{}"],
    ["plot", "{}"],
    ["estimate", "{}"],
    ["export", "{}"],
    ["regress", "{}"],
    ["tune", "--wishes", "{}"],
    ["gains", "show", "{}"],
    ["gains", "diff", "{}", "{}"],
    ["gains", "history", "{}"],
    ["serve", "--token-file", "{}"],
    ["serve", "--tls-cert", "{}", "--tls-key", "{}"],
    ["serve", "--scenario", "{}"],
    ["gui", "--scenario", "{}"],
    ["monitor", "--token-file", "{}"],
)
"""Commands that read a file; {} stands for its name."""


@pytest.mark.parametrize("command", READERS, ids=lambda command: " ".join(command[:-1]))
def test_what_is_no_file_is_refused(command, refused, tmp_path, monkeypatch):
    """A pipe that nobody writes to would be waited for, and a device read without end."""
    monkeypatch.chdir(tmp_path)
    for name in ("pipe", "pipe.yaml", "pipe.urdf", "pipe.mcap"):
        os.mkfifo(name)
    (tmp_path / "folder").mkdir()
    names = ["", " ", "folder", "pipe", "pipe.yaml", "pipe.urdf", "pipe.mcap", "/dev/zero"]
    for name in [*names, "gone", "x" * 5000, "no\0name", "~nobodyhere/x", "ünïcode☃"]:
        said = refused(*(name if word == "{}" else word for word in command))
        assert "Errno" not in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["inspect", ""], "the text after 'inspect' is empty"),
        (["step", "--gains", ""], "the text after '--gains' is empty"),
        (["step", "--gains="], "'--gains=' has no value"),
        (["replay", " "], "the text after 'replay' is empty"),
    ],
)
def test_an_unset_variable_of_the_shell_is_noticed(command, said, refused):
    assert said in refused(*command)


def test_a_log_larger_than_memory_is_refused(refused, tmp_path):
    path = tmp_path / "huge.mcap"
    with path.open("wb") as file:
        file.write(b"\x89MCAP0\r\n")
        file.truncate(1 << 40)  # a sparse file: it takes no room
    for command in ("replay", "plot", "export", "estimate"):
        assert "is larger than" in refused(command, path)
