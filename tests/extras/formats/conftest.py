"""Files to write, and parts of a model: the fixtures of the core's own tests of plants."""

from tests.plant.rotor_sources.conftest import joint, link
from tests.plant.worlds.conftest import fault, read, write

__all__ = ["fault", "joint", "link", "read", "write"]
