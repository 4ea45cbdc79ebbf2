"""Token files are private or refused."""

import os

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.authentication import (
    Tokens,
    new_nonce,
    new_token,
    read_tokens,
    write_tokens,
)
from workbench.link.messages import Login, Role

VIEW, COMMAND = "v" * 16, "c" * 16
GOOD = f"view: {VIEW}\ncommand: {COMMAND}\n"


@pytest.fixture
def token_file(tmp_path):
    def make(text, mode=0o600):
        path = tmp_path / "tokens"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        path.chmod(mode)
        return path

    return make


def test_a_nonce_is_16_bytes_and_never_the_same():
    nonces = {new_nonce() for _ in range(100)}
    assert len(nonces) == 100
    assert {len(bytes.fromhex(nonce)) for nonce in nonces} == {16}


def test_tokens_are_read(token_file):
    tokens = read_tokens(token_file(f"# the lab's\n\n  command: {COMMAND}\r\nview:{VIEW}\n"))
    assert tokens == Tokens(VIEW, COMMAND)
    assert tokens.of(Role.VIEW) == VIEW
    assert tokens.of(Role.COMMAND) == COMMAND


def test_tokens_are_not_printed():
    assert VIEW not in repr(Tokens(VIEW, COMMAND))
    assert VIEW not in repr(Login(token=VIEW))


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o602, 0o644, 0o610, 0o601])
def test_a_file_that_others_may_touch_is_refused(token_file, mode):
    with pytest.raises(WorkbenchError, match=r"others may read it .*: run chmod 600 "):
        read_tokens(token_file(GOOD, mode))


def test_a_file_that_only_its_owner_reads_is_taken(token_file):
    assert read_tokens(token_file(GOOD, 0o400)).view == VIEW


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "add a line `view: TOKEN`"),
        (f"view: {VIEW}", "add a line `command: TOKEN`"),
        (f"view: {VIEW}\nview: {VIEW}", ":2: expected one line"),
        (f"view: {VIEW}\ncommand: short", ":2: the command token has 5 characters: give it 16"),
        (f"view: {VIEW}\ncommand: {VIEW}", "both tokens are the same"),
        (f"{GOOD}admin: {VIEW}", ":3: expected one line"),
        (f"{GOOD}command {COMMAND}", ":3: expected one line"),
        (f"view: two words {VIEW}", ":1: expected one line"),
        (f"view: {VIEW}\ncommand: {COMMAND}\a", ":2: a token has at most 1024 bytes, all print"),
        (f"view: {VIEW}\ncommand: {'ü' * 513}", ":2: a token has at most 1024 bytes"),
        (b"view: \xff", "byte 6 is not UTF-8"),
        ("#" * 5000, "at most 4096 bytes"),
    ],
)
def test_what_a_token_file_may_not_be(token_file, text, said):
    with pytest.raises(WorkbenchError) as error:
        read_tokens(token_file(text))
    assert said in str(error.value)
    assert VIEW not in str(error.value)


def test_what_is_no_file_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe", 0o600)
    with pytest.raises(WorkbenchError, match="must be a plain file"):
        read_tokens(tmp_path / "pipe")
    with pytest.raises(WorkbenchError, match="cannot be read: No such file"):
        read_tokens(tmp_path / "none")
    with pytest.raises(WorkbenchError):
        read_tokens(tmp_path)
    with pytest.raises(WorkbenchError, match="cannot be read"):
        read_tokens("a\0b")


def test_a_token_file_that_is_made_can_be_read_and_is_not_written_over(tmp_path):
    path = tmp_path / "tokens"
    tokens = write_tokens(path)
    assert path.stat().st_mode & 0o777 == 0o600
    assert read_tokens(path) == tokens
    with pytest.raises(WorkbenchError, match="exists already"):
        write_tokens(path)
    assert read_tokens(path) == tokens
    with pytest.raises(WorkbenchError, match="cannot be written: No such file"):
        write_tokens(tmp_path / "none" / "tokens")


def test_a_new_token_is_a_word_that_no_command_takes_for_an_option():
    # 24 bytes in base64 begin with "-" once in 64 times: `--pilot ADDRESS -x7…` is refused.
    assert all(new_token()[0].isalnum() for _ in range(500))
