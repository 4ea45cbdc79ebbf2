"""What `workbench fly --list` prints: the scenarios and worlds that are shipped."""

from workbench.commands.printing import print_json, print_table


def print_shipped(*, as_json: bool) -> None:
    """Print the shipped scenarios and worlds with their titles."""
    from workbench.common.resources import (
        find_scenario,
        find_world,
        list_scenarios,
        list_worlds,
        worlds_dir,
    )
    from workbench.plant.worlds.reading import read_world
    from workbench.scenario.scenario import load_scenario

    scenarios = {name: load_scenario(find_scenario(name)) for name in list_scenarios()}
    packages = {"worlds": str(worlds_dir())}
    worlds = {name: read_world(find_world(name), packages) for name in list_worlds()}
    if as_json:
        print_json(
            {
                "scenarios": [
                    {"name": name, "title": scenario.title, "duration": scenario.duration}
                    for name, scenario in scenarios.items()
                ],
                "worlds": [{"name": name, "title": world.title} for name, world in worlds.items()],
            }
        )
        return
    print("scenarios")
    print_table(
        [(f"  {name}", f"{each.duration:g} s", each.title) for name, each in scenarios.items()],
        left=(0, 2),
    )
    print("\nworlds, for --world")
    print_table([(f"  {name}", each.title) for name, each in worlds.items()], left=(0, 1))
