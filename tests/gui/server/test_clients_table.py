"""The table of clients: in place, so that a selection outlives its updates."""

from dataclasses import replace

import pytest

from workbench.gui.server.clients_panel import CLIENT_COLUMNS, ClientsPanel
from workbench.link.backplane import ClientStatus, ServerStatus
from workbench.link.messages import ControlOwner, ControlState, LinkLossStage, Role
from workbench.live.messages import NetworkView

ANNA = ClientStatus(1, "10.0.0.1:5001", "anna", "tcp", Role.COMMAND, 120.4, 0.012, 3, 1)
BEN = ClientStatus(2, "10.0.0.2:5002", "", "websocket", Role.VIEW, 30.0, 12.0, 0, 0)
CARL = ClientStatus(3, "10.0.0.3:5003", "carl", "tls", None, 0.0, float("inf"), 0, 0)


def flies(peer, name, stage=LinkLossStage.LIVE):
    return ControlState(ControlOwner.CLIENT, peer, name, stage, 0.0, f"{name} took control")


def texts(table):
    return [
        [table.item(row, column).text() for column in range(table.columnCount())]
        for row in range(table.rowCount())
    ]


@pytest.fixture
def panel(workspace, qtbot):
    made = ClientsPanel(workspace.flight)
    qtbot.addWidget(made)
    return made


def test_a_client_is_a_row_of_words(panel):
    table = panel.table
    panel.show_network(network(ANNA, BEN, CARL, control=flies(1, "anna")))
    number = "\N{NO-BREAK SPACE}"
    assert texts(table) == [
        ["anna", "10.0.0.1:5001", "tcp", "fly", "flies", "120", f"12{number}ms", "3", "1"],
        ["client 2", "10.0.0.2:5002", "websocket", "watch", "–", "30", f"12{number}s", "0", "0"],
        ["carl", "10.0.0.3:5003", "tls", "login", "–", "0", "–", "0", "0"],
    ]
    heads = [table.horizontalHeaderItem(column).text() for column in range(9)]
    assert heads == [name for name, _ in CLIENT_COLUMNS]


def test_a_silent_holder_is_said(panel):
    table = panel.table
    panel.show_network(network(ANNA, control=flies(1, "anna", LinkLossStage.HOLD)))
    assert table.item(0, 4).text() == "silent, holds"


def test_only_cells_that_changed_are_told(panel):
    table = panel.table
    panel.show_network(network(ANNA, BEN))
    changed = []
    table.itemChanged.connect(lambda item: changed.append((item.row(), item.column())))
    panel.show_network(network(ANNA, replace(BEN, rate=31.0)))
    assert set(changed) == {(1, 5)}


def test_who_leaves_takes_only_its_own_row(panel):
    table = panel.table
    panel.show_network(network(ANNA, BEN, CARL))
    panel.show_network(network(ANNA, CARL))
    assert [row[0] for row in texts(table)] == ["anna", "carl"]
    assert panel.peer_at(1) == 3
    panel.show_network(network())
    assert table.rowCount() == 0


def network(*peers, control=None):
    return NetworkView(ServerStatus("127.0.0.1:7733", "", peers, {}, ()), control)


def test_a_selection_outlives_updates_and_the_leaving_of_others(panel):
    panel.show_network(network(ANNA, BEN, CARL))
    panel.table.selectRow(2)
    panel.show_network(network(replace(BEN, rate=1.0), replace(CARL, rate=2.0)))
    assert panel.chosen == 1
    assert panel.peer_at(panel.chosen) == 3
    assert panel.disconnect_button.isEnabled()
    panel.show_network(network(BEN))
    assert panel.chosen is None
    assert not panel.disconnect_button.isEnabled()


def test_only_the_button_that_helps_can_be_pressed(panel):
    assert not panel.take_over.isEnabled()
    panel.show_network(network(ANNA, control=flies(1, "anna")))
    assert panel.control.text() == "anna has control."
    assert panel.take_over.isEnabled()
    assert not panel.give_back.isEnabled()
    mine = ControlState(
        ControlOwner.OPERATOR, 0, "", LinkLossStage.LIVE, 0.0, "the operator took over"
    )
    panel.show_network(network(ANNA, control=mine))
    assert panel.control.text() == "You have control; clients wait."
    assert panel.give_back.isEnabled()
    assert not panel.take_over.isEnabled()
