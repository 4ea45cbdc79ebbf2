"""`workbench reproduce`: flown once; what it says, writes and returns."""

import json

import pytest

from workbench.design.reproduce import AVERAGING_WINDOW_TEXT, PAPER_FIGURES

PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("reproduce") / "out"


@pytest.fixture(scope="module")
def said(run, folder):
    return run("reproduce", "--json", "--output", folder)


@pytest.fixture(scope="module")
def rows(said):
    return {row["axis"]: row for row in said.json["rows"]}


@pytest.mark.slow
def test_it_is_as_the_issue_demands(said, rows):
    assert said.code == 0, said.err
    assert said.json["violations"] == []
    for figure in PAPER_FIGURES:
        row = rows[figure.axis]
        assert row["mean_acceleration"] == pytest.approx(figure.mean_acceleration, rel=0.05)
        assert row["overshoot"] <= 5.0
        assert row["steady_state_error"] <= 1.0
    assert rows["z"]["mean_force"] == pytest.approx(22.3, rel=0.03)
    assert rows["x"]["mean_force"] == pytest.approx(7.5, rel=0.05)
    assert rows["y"]["mean_force"] == pytest.approx(7.5, rel=0.05)
    assert rows["x"]["coupling"]["z"] <= 0.05
    assert rows["x"]["coupling"]["y"] <= 0.01


@pytest.mark.slow
def test_figures_logs_and_summary_are_written(said, folder):
    names = {f"figure{number}.{kind}" for number in (8, 9, 10, 11) for kind in ("png", "csv")}
    assert {path.name for path in folder.iterdir()} == names | {"reproduce.json"}
    assert all((folder / name).read_bytes()[:4] == PNG for name in names if name.endswith("png"))
    assert json.loads((folder / "reproduce.json").read_text()) == said.json
    assert set(said.json["files"]) == {str(path) for path in folder.iterdir()}


@pytest.mark.slow
def test_the_table_sets_ours_beside_the_papers(run, out):
    table = run("reproduce", "--no-plots", "--output", out).out
    assert table.split()[:4] == ["paper", "ours", "difference", "demanded"]
    for figure in PAPER_FIGURES:
        assert f"{figure.axis}: command {figure.command:g}" in table
    assert table.count("mean acceleration") == 5  # four, and once under the table
    assert AVERAGING_WINDOW_TEXT in table
    assert "2.18 kg" in table
    assert not list(out.glob("*.png"))


@pytest.mark.slow
def test_what_is_not_as_demanded_is_named_and_returns_1(run, out):
    said = run("reproduce", "--set", "kp_velocity_z=2", "--no-plots", "--output", out)
    assert said.code == 1
    assert "requirements not met: mean acceleration of the z step" in said.err
    assert "<- missed" in said.out
    assert (out / "reproduce.json").is_file()


@pytest.mark.slow
def test_a_step_that_never_arrives_is_null_in_json_and_not_as_demanded(run, out):
    said = run("reproduce", "--set", "kp_yaw_rate=0", "--no-plots", "--json", "--output", out)
    assert said.code == 1
    yaw = said.json["rows"][3]
    assert yaw["t90"] is None
    assert yaw["mean_force"] is None
    assert yaw["met"] is False


def test_a_folder_that_cannot_be_is_refused_before_the_flight(refused, tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    assert f"{blocker}/out/reproduce.json" in refused("reproduce", "--output", blocker / "out")
    assert list(tmp_path.iterdir()) == [blocker]
