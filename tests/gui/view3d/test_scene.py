"""A log's motion in W: interpolated, from the true motion or the estimate. Oracle: scipy."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.flight import Flight
from workbench.common.series import Series
from workbench.gui.view3d.scene import Scene, log_track

TIME = np.linspace(2.0, 6.0, 81)


def contents(**signals):
    """A log of signals at `TIME`; those named are left as they are."""
    values = {name.replace("__", "."): np.asarray(each) for name, each in signals.items()}
    made = {name: Series(name, "1", TIME, each) for name, each in values.items()}
    return Flight("x500", Path("it.mcap"), "", made, end=6.0)


def motion(source="position_data", **changed):
    flown = {
        "x": TIME,
        "y": 2.0 * TIME,
        "z": np.full(81, 1.5),
        "roll": np.full(81, 0.3),
        "pitch": np.full(81, -0.2),
        "yaw": np.angle(np.exp(1j * TIME)),  # jumps from π to -π
        **changed,
    }
    return {f"{source}__{name}": values for name, values in flown.items()}


def test_a_pose_lies_between_its_samples_and_turns_as_scipy_has_it():
    track = log_track(contents(**motion()))
    for time in (2.0, 3.1415, 3.16, 5.99):
        pose = track.at(time)
        assert pose[:3, 3] == pytest.approx([time, 2.0 * time, 1.5])
        expected = Rotation.from_euler("xyz", [0.3, -0.2, time]).as_matrix()
        np.testing.assert_allclose(pose[:3, :3], expected, atol=1e-9)
    assert track.at(99.0)[0, 3] == 6.0
    assert track.name == "it.mcap"


def test_the_estimate_stands_in_and_without_a_position_there_is_no_motion():
    known = np.where(TIME > 3.0, 2.0 * TIME, np.nan)  # nothing is known of the first second
    flown = motion("estimate", y=known)
    for name in ("roll", "pitch", "yaw"):
        flown.pop(f"estimate__{name}")
    track = log_track(contents(**flown))
    assert track.time[0] == pytest.approx(3.05)
    np.testing.assert_array_equal(track.at(4.0)[:3, :3], np.eye(3))
    both = log_track(contents(**motion("estimate"), **motion(z=np.full(81, 7.0))))
    assert both.at(4.0)[2, 3] == 7.0  # the true motion
    assert log_track(contents(imu__specific_force=np.ones(81))) is None
    nowhere = np.full(81, np.nan)
    assert log_track(contents(**motion(x=nowhere))) is None


def test_who_looks_is_told_of_another_log_and_another_time(qapp):
    scene, told = Scene(), []
    scene.log_changed.connect(lambda: told.append(scene.log))
    scene.replayed.connect(lambda: told.append(scene.time))
    scene.show_log(contents(**motion()))
    scene.replay(3.5)
    scene.show_log(None)
    assert told == ["it.mcap", 3.5, ""]
    assert scene.track is None
