"""World files to write, and what is wrong with them."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.worlds.reading import read_world

BOX_SDF = """<sdf version="1.9"><model name="box"><link name="base_link">{}</link></model></sdf>"""
TOUCHED = '<collision name="c"><geometry><box><size>1 2 3</size></box></geometry></collision>'
DRAWN = '<visual name="v"><geometry><box><size>1 2 3</size></box></geometry></visual>'


@pytest.fixture
def write(tmp_path):
    """Write a file, with the folders above it, and return its path."""

    def write_file(text: str, name: str = "world.yaml"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    return write_file


@pytest.fixture
def read(write):
    """Write a world file and read it."""
    return lambda text, name="world.yaml", **packages: read_world(write(text, name), packages)


@pytest.fixture
def fault(write):
    """Return what is said of a world file, which is one line that begins with its path."""

    def say(text: str, name: str = "world.yaml") -> str:
        path = write(text, name)
        with pytest.raises(WorkbenchError) as caught:
            read_world(path)
        said = str(caught.value)
        assert said.startswith(str(path))
        assert "\n" not in said
        return said.removeprefix(str(path))

    return say


@pytest.fixture
def box(write):
    """A model beside the world file: a box of 1 x 2 x 3 m that is touched and drawn."""
    return write(BOX_SDF.format(TOUCHED + DRAWN), "box.sdf")
