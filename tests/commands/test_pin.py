"""`workbench pin`: what it refuses; tests/docs/test_docs_first_drone.py pins a step."""

import pytest


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["mine.yaml"], "is no name for a spec: name it NAME.spec.yaml"),
        (["mine.spec.yaml", "--amplitude", "0"], "the amplitude is 0"),
        (["mine.spec.yaml", "--model", "nowhere"], "unknown model 'nowhere'"),
    ],
)
def test_what_cannot_be_pinned_is_refused(refused, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused("pin", *words)
    assert not list(tmp_path.iterdir())


def test_a_spec_is_not_written_over(refused, tmp_path):
    spec = tmp_path / "mine.spec.yaml"
    spec.write_text("mine")
    assert "is there already" in refused("pin", spec)
    assert spec.read_text() == "mine"
