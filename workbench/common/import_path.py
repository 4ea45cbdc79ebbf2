"""The order in which this process looks for modules."""

import os
import sys
from pathlib import Path

_ROOT = str(Path(__file__).resolve().parents[2])
"""Folder of the package `workbench`."""


def own_packages_first() -> None:
    """Let packages of the own environment come before those on PYTHONPATH.

    A sourced ROS puts its packages there, with a xacro and plugins for pytest. The folder of this
    workbench keeps its place.
    """
    variable = os.environ.get("PYTHONPATH")
    added = {str(Path(each).absolute()) for each in variable.split(os.pathsep)} if variable else {}
    later = [path for path in sys.path if path in added and path != _ROOT]
    sys.path[:] = [path for path in sys.path if path not in later] + later
