"""What the app opens with."""

import pytest
from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError
from workbench.gui.first_flight import DEFAULT_APP_SCENARIO, first_flight, last_setup
from workbench.live.choice import Choice
from workbench.scenario.scenario import Scenario
from workbench.scenario.scenario_file import save_scenario


@pytest.fixture
def store(tmp_path, qapp):
    return QSettings(str(tmp_path / "kept.ini"), QSettings.Format.IniFormat)


def test_at_first_it_is_the_default(store):
    assert first_flight(store) == Choice(DEFAULT_APP_SCENARIO)


def test_what_was_set_up_flies_again(store):
    save_scenario(Scenario(world="room"), last_setup(store))
    assert first_flight(store).load().world == "room"


@pytest.mark.parametrize(
    "text", ["world: /gone/world.yaml", "vehicle: {model: /gone/drone.sdf}", "- no mapping", "a: ["]
)
def test_what_cannot_fly_any_more_is_said_once_and_forgotten(store, text):
    last_setup(store).write_text(text)
    with pytest.raises(WorkbenchError, match="cannot be flown again"):
        first_flight(store)
    assert first_flight(store) == Choice(DEFAULT_APP_SCENARIO)
