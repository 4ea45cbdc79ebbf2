"""Descriptions and worlds that try to read files outside of their folder."""

import pytest

from tests.plant.conftest import quad
from tests.plant.test_hostile import assert_nothing_outside_is_read, external, outcome

__all__ = ["outcome", "quad"]


def sdf(body: str) -> dict[str, str]:
    return {"a.sdf": f'<sdf version="1.9"><model name="m"><link name="l"/>{body}</model></sdf>'}


def mjcf(body: str) -> dict[str, str]:
    return {"a.xml": f"<mujoco>{body}</mujoco>"}


READS = {
    "sdf include": sdf("<include><uri>file://{outside}/secret.sdf</uri></include>"),
    "sdf include, relative": sdf("<include><uri>../secret.sdf</uri></include>"),
    "sdf include, link": sdf("<include><uri>link.sdf</uri></include>"),
    "sdf include, model": sdf("<include><uri>model://x/../secret.sdf</uri></include>"),
    "sdf model folder": {
        **sdf("<include><uri>model://x</uri></include>"),
        "x/model.config": "<model><sdf>../../secret.sdf</sdf></model>",
    },
    "sdf external entity": {"a.sdf": external("<sdf>&e;</sdf>", "../secret.sdf")},
    "mjcf include": mjcf('<include file="../secret.xml"/>'),
    "mjcf include, absolute": mjcf('<include file="{outside}/secret.xml"/>'),
    "mjcf include, link": mjcf('<include file="link.xml"/>'),
    "world include": {
        "w.sdf": '<sdf version="1.9"><world name="w"><include><uri>../secret.sdf</uri></include>'
        "</world></sdf>"
    },
}
"""Files outside of the folder, in all ways of naming them."""


@pytest.mark.parametrize("name", READS)
def test_no_file_outside_its_folder_is_read(outcome, name):
    assert_nothing_outside_is_read(outcome(READS[name]))
