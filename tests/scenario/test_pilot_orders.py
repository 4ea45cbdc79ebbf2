"""Each method of a pilot is the record that a script has for it."""

from workbench.scenario.pilot_orders import PilotOrders
from workbench.scenario.scenario import Action, Gust, Push
from workbench.session.action_check import checked_action


class Noted(PilotOrders[Action]):
    """Returns what it is ordered, with plain numbers."""

    def do(self, action: Action) -> Action:
        return checked_action(action)


def test_each_method_is_an_action(case):
    pilot = Noted()
    for ordered, action in (
        (pilot.set("kp_roll", 3), Action(set={"kp_roll": 3.0})),
        (pilot.set_all({"a": 1.0, "b": 2.0}), Action(set={"a": 1.0, "b": 2.0})),
        (pilot.command((1, 2, 3)), Action(velocity=[1.0, 2.0, 3.0])),
        (pilot.command(yaw_rate=0.5), Action(yaw_rate=0.5)),
        (pilot.go_to((1, 2, 3)), Action(go_to=[1.0, 2.0, 3.0])),
        (pilot.request("land"), Action(request="land")),
        (pilot.request("take_off", 2), Action(request="take_off", height=2.0)),
        (pilot.gust((1, 2, 3), 0.5), Action(gust=Gust([1.0, 2.0, 3.0], 0.5))),
        (
            pilot.push((1, 2, 3), (4, 5, 6), 0.2, (7, 8, 9)),
            Action(push=Push([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 0.2, [7.0, 8.0, 9.0])),
        ),
    ):
        with case(action):
            assert ordered == action
