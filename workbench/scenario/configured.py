"""Read the description and the world of a scenario."""

import logging
import math
from collections.abc import Mapping

from workbench.common.resources import find_file, find_model, find_world, worlds_dir
from workbench.estimation.settings import COMPLEMENTARY
from workbench.plant.description import Description, read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.plausible import implausible_values
from workbench.plant.remarks import counts_by_kind
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.reading import read_world
from workbench.plant.worlds.world import World
from workbench.scenario.scenario import Scenario, VehicleConfig

MAX_LOGGED_REMARKS = 5
"""Largest number of remarks on a world that are logged individually."""


def read_configured(config: VehicleConfig) -> Description:
    """Return the description of a scenario.

    Raises:
        WorkbenchError: if it does not exist, or cannot be read.
    """
    rotors = find_file(config.rotors) if config.rotors else ""
    return read_description(find_model(config.model), config.args, config.packages, rotors)


def configured_vehicle(config: VehicleConfig) -> Vehicle:
    """Return the vehicle of a scenario, as known to its controller.

    Raises:
        WorkbenchError: as `read_configured`, and if it cannot fly.
    """
    return make_vehicle(read_configured(config))


def read_configured_world(scenario: Scenario) -> World:
    """Return the world of a scenario; the packages of its vehicle are searched as well.

    Raises:
        WorkbenchError: if it does not exist, or cannot be read.
    """
    packages = {"worlds": str(worlds_dir())} | scenario.vehicle.packages
    return read_world(find_world(scenario.world), packages)


def log_world_remarks(world: World) -> None:
    """Log where a world differs from its file."""
    logger = logging.getLogger("workbench")
    found = sorted(world.remarks, key=lambda remark: remark.kind == "ignored")
    for remark in found[:MAX_LOGGED_REMARKS]:
        logger.info("%s", remark)
    if len(found) > MAX_LOGGED_REMARKS:
        logger.info("%s: and so on, %s in all", world.source, counts_by_kind(found))


def warn_of_start_contact(obstacle: str, clearance: float, distance: float) -> None:
    """Warn that a flight begins in an obstacle, or near enough to touch it.

    Args:
        obstacle: the nearest one.
        clearance: needed by the drone in any orientation [m].
        distance: from its surface to the middle of the drone [m], negative inside.
    """
    logger = logging.getLogger("workbench")
    if distance < 0.0:
        logger.info("the flight begins inside '%s': let it start at another position", obstacle)
    elif clearance < 0.0:
        logger.info(
            "the flight begins %.2g m from '%s', within the drone's own reach of %.2g m",
            distance,
            obstacle,
            distance - clearance,
        )


MIN_TILT_ERROR_RAD = math.radians(1.0)
"""Attitude error of the complementary filter by a gyro bias from which on it is told [rad]."""


def warn_of_gyro_bias(vehicle: Vehicle, scenario: Scenario, values: Mapping[str, float]) -> None:
    """Warn of a gyro bias that tilts the complementary filter until it is estimated.

    Its attitude error is the bias over kp, and decays with the time constant kp / ki.

    Args:
        vehicle: with its sensors.
        scenario: with the estimator.
        values: of the parameters by name.
    """
    if scenario.estimator != COMPLEMENTARY or not scenario.sensors.noise:
        return
    kp, ki = values["complementary_kp"], values["complementary_ki"]
    for sensor in vehicle.body_imus:
        bias = max(abs(each.bias_mean) + each.bias_stddev for each in sensor.angular_velocity)
        if kp > 0.0 and bias / kp > MIN_TILT_ERROR_RAD:
            after = (
                f"for some {kp / ki:.0f} s" if ki > 0.0 else "for good, as complementary_ki is 0"
            )
            logging.getLogger("workbench").info(
                "%s: a gyro bias of %.2g rad/s turns the attitude of the complementary filter by "
                "up to %.2g° about each axis, %s: let the drone fly on the estimator ekf",
                sensor.name,
                bias,
                math.degrees(bias / kp),
                after,
            )


def log_held_joints(description: Description) -> None:
    """Log the joints of a description that do not move, and why."""
    logger = logging.getLogger("workbench")
    held = [remark for remark in description.remarks if remark.kind == "held"]
    for remark in held[:MAX_LOGGED_REMARKS]:
        logger.info("%s", remark)
    if len(held) > MAX_LOGGED_REMARKS:
        logger.info("%s: and %d further joints are held", description.source, len(held))


def log_remarks(description: Description, vehicle: Vehicle) -> None:
    """Log the remarks on a description, and its implausible numbers."""
    logger = logging.getLogger("workbench")
    log_held_joints(description)
    found = [remark for remark in description.remarks if remark.kind not in ("ignored", "held")]
    if found:
        said = counts_by_kind(found)
        logger.info("%s: %s; `workbench inspect` lists them", description.source, said)
    for doubt in implausible_values(vehicle):
        logger.info("%s: %s", description.source, doubt)
