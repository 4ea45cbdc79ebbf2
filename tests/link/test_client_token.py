import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.authentication import read_token, write_tokens
from workbench.link.messages import Role


def write(path, text, mode=0o600):
    path.write_bytes(text)
    path.chmod(mode)
    return path


def test_each_role_has_its_line_of_a_servers_file(tmp_path):
    tokens = write_tokens(tmp_path / "tokens")
    assert read_token(tmp_path / "tokens", Role.VIEW) == tokens.view
    assert read_token(tmp_path / "tokens", Role.COMMAND) == tokens.command


def test_one_line_is_enough_for_its_role(tmp_path):
    path = write(tmp_path / "t", b"# from Ada\nview:  abcdefghijklmnop  \n")
    assert read_token(path, Role.VIEW) == "abcdefghijklmnop"
    with pytest.raises(WorkbenchError, match="has no line `command: TOKEN`"):
        read_token(path, Role.COMMAND)


@pytest.mark.parametrize(
    ("text", "mode", "said"),
    [
        (b"view: abcdefghijklmnop", 0o644, "run chmod 600"),
        (b"view: abcdefghijklmnop", 0o660, "run chmod 600"),
        (b"", 0o600, "has no line `view: TOKEN`"),
        (b"view:\n", 0o600, "has no line"),
        (b"view: \xff\n", 0o600, "byte 6 is not UTF-8"),
        (b"#" * 4097, 0o600, "has at most 4096 bytes"),
    ],
)
def test_a_file_that_does_not_do_is_a_sentence(tmp_path, text, mode, said):
    with pytest.raises(WorkbenchError, match=said):
        read_token(write(tmp_path / "t", text, mode), Role.VIEW)


def test_a_missing_file_is_a_sentence(tmp_path):
    with pytest.raises(WorkbenchError, match="cannot be read: No such file"):
        read_token(tmp_path / "missing", Role.VIEW)
    with pytest.raises(WorkbenchError, match="cannot be read: Is a directory"):
        read_token(tmp_path, Role.VIEW)
