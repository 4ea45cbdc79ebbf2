"""`workbench gateway`: what its kinds refuse; that they pass on is tested beside each."""

import subprocess
import sys

import pytest

from workbench.commands.cli import _parser, main
from workbench.extras.gateways.command import link_options


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "no kind of gateway is named: write foxglove, plotjuggler, ros2 or mavlink"),
        (["mqtt"], "unknown kind 'mqtt'"),
        (["foxglove", "127.0.0.1:1"], "nobody listens at 127.0.0.1:1"),
        (["plotjuggler", "127.0.0.1:1"], "nobody listens at 127.0.0.1:1"),
        (["ros2", "127.0.0.1:1"], "nobody listens at 127.0.0.1:1"),
        (["foxglove", "--listen", "here:there"], "the port 'there'"),
        (["plotjuggler", "--to", "a b"], "is not an address"),
        (["plotjuggler", "--rate", "0"], "the rate 0.0 is not within"),
        (["foxglove", "--token-file", "missing"], "missing: cannot be read"),
        (["foxglove", "127.0.0.1:x"], "the port 'x'"),
        (["foxglove", "--tls", "missing.pem"], "missing.pem: no such file"),
        (["foxglove", "--rate", "fast"], "the rate 'fast'"),
    ],
)
def test_bad_input_is_a_sentence(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert main(["gateway", *words]) == 2
    assert said in capsys.readouterr().err


def test_a_gateway_uses_the_token_to_view_unless_it_may_command(tmp_path):
    file = tmp_path / "tokens"
    file.write_text(f"view: {'v' * 16}\ncommand: {'c' * 16}\n")
    file.chmod(0o600)
    words = ["gateway", "mavlink", "--token-file", str(file)]
    for more, role, token in (((), "view", "v"), (("--allow-commands",), "command", "c")):
        args = _parser("gateway").parse_args([*words, *more])
        link = link_options(args, "mavlink", flies=args.allow_commands)
        assert (link.role.value, link.token) == (role, token * 16)


def test_others_may_watch_in_foxglove_only_if_that_is_said(capsys):
    assert main(["gateway", "foxglove", "127.0.0.1:1", "--listen", "0.0.0.0:8765"]) == 2
    assert "--anybody" in capsys.readouterr().err


def test_the_package_of_messages_is_written(tmp_path, capsys):
    assert main(["gateway", "ros2", "--write-messages", str(tmp_path)]) == 0
    assert (tmp_path / "dh_drone_msgs" / "package.xml").is_file()


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom workbench.commands.cli import main\n"
        "try:\n    main(['gateway', 'ros2', '--help'])\nexcept SystemExit:\n    pass\n"
        "print({'asyncio', 'ssl', 'numpy', 'foxglove', 'cyclonedds'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "set()", done.stderr
