"""A full device is a sentence, and leaves no file."""

from pathlib import Path

import pytest

from tests.commands.test_full_disk import FEW_BYTES, QUAD, files_of_at_most, unheld

__all__ = ["unheld"]


@pytest.mark.parametrize(
    "command", [f"excite --duration 20 {QUAD}", "import table.csv --save table.mcap"]
)
def test_a_full_device(command, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("table.csv").write_text("t,x\n0,0\n1,0\n2,0\n3,0\n")
    Path("table.mapping.yaml").write_text(
        "time: {column: t, unit: s}\ncolumns:\n  x: {signal: imu.angular_velocity.x, unit: deg/s}\n"
    )
    before = sorted(tmp_path.iterdir())
    with files_of_at_most(FEW_BYTES):
        said = run(*command.split())
    assert said.code == 2, said
    assert "cannot be written: File too large" in said.err.splitlines()[-1]
    assert sorted(tmp_path.iterdir()) == before


def test_the_place_is_checked_before_a_log_is_read(refused, tmp_path, monkeypatch, case):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    for words, said in (
        ("import gone.csv --save file/a.mcap", "file/a.mcap: cannot be written: Not a directory"),
        ("import gone.csv --save a.txt", "let its name end in .mcap"),
        ("import gone.csv", "gone.csv: no such file"),
    ):
        with case(words):
            assert said in refused(*words.split())
    assert sorted(tmp_path.iterdir()) == [tmp_path / "file"]
