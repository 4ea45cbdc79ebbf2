"""The description that a scenario names, read: what comes before anything is built of it."""

import logging

from workbench.plant.description import Description, read_description
from workbench.plant.plausible import doubts
from workbench.plant.remarks import summed_up
from workbench.plant.vehicle import Vehicle
from workbench.resources import find_file, find_model
from workbench.scenario import VehicleConfig


def read_configured(config: VehicleConfig) -> Description:
    """Return the description that a scenario names.

    Raises:
        WorkbenchError: if it is not there, or cannot be read.
    """
    rotors = find_file(config.rotors) if config.rotors else ""
    return read_description(find_model(config.model), config.args, config.packages, rotors)


def tell_remarks(description: Description, vehicle: Vehicle) -> None:
    """Say that a description was not taken word for word, and what of it is unlikely."""
    logger = logging.getLogger("workbench")
    found = [remark for remark in description.remarks if remark.kind != "ignored"]
    if found:
        said = summed_up(found)
        logger.info("%s: %s; `workbench inspect` lists them", description.source, said)
    for doubt in doubts(vehicle):
        logger.info("%s: %s", description.source, doubt)
