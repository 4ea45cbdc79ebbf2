"""The page on prediction: its figures are those of `tests/design/predict/test_prediction.py`."""

from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs/prediction.md").read_text(encoding="utf-8")


def test_the_page_names_every_method_and_every_effect():
    from workbench.commands.predict import EFFECTS
    from workbench.design.predict.past import Effects
    from workbench.design.predict.prediction import METHODS

    assert Effects._fields == EFFECTS
    for name in (*METHODS, *EFFECTS):
        assert name in PAGE.lower(), name
