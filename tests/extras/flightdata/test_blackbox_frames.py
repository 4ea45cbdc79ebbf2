"""Blackbox logs with predicted frames, against the numbers that were written."""

from dataclasses import replace

import numpy as np
import pytest

from tests.extras.flightdata.blackbox_writer import (
    I_INTERVAL,
    Field,
    flight_fields,
    predicted_blackbox,
    whole_bytes,
)
from tests.extras.flightdata.foreign_files import unsigned, vb
from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.readers.blackbox import read_blackbox
from workbench.extras.flightdata.readers.blackbox_frames import read_frames

COUNT = 400


def check(found, fields, rows):
    """Check that exactly these rows were read, with all their numbers."""
    np.testing.assert_array_equal(found.fields["loopIteration"], rows)
    for name, field in fields.items():
        np.testing.assert_array_equal(found.fields[name], np.array(field.values)[rows], name)


def pause_flight(fields, begin, updates):
    """Let a number of control updates of 500 us pass in front of a row, in place."""
    for name, step in (("loopIteration", updates), ("time", 500 * updates)):
        old = fields[name]
        values = [each + (step if i >= begin else 0) for i, each in enumerate(old.values)]
        fields[name] = replace(old, values=values)


def test_all_encodings_and_predictions_give_the_numbers_that_were_written(case):
    for seed in range(3):
        with case(seed):  # the counter of the time overflows in the middle
            fields = flight_fields(COUNT, begin_us=2**32 - 100_000, seed=seed)
            data, _ = predicted_blackbox(fields)
            found = read_frames(data, COUNT + 1)
            check(found, fields, np.arange(COUNT))
            assert found.damage == "" and found.headers["acc_1G"] == 2048


def test_numbers_of_all_sizes_in_encodings_of_several_fields(case):
    """From no bit to 32 bits, with both signs, in both versions of the format."""
    sizes = [0, 1, -1, 7, -8, 8, 15, -16, 31, -32, 63, -64, 127, -128, 128, 8191, -8192, 32767]
    wide = [*sizes, -32768, 2**23 - 1, -(2**23), 2**24, 2**31 - 1, -(2**31)]
    for encoding, count, values, version in (
        (7, 3, wide, 2),
        (10, 3, wide, 2),
        (8, 4, sizes, 2),
        (8, 4, sizes, 1),
        (6, 8, wide, 2),
        (6, 1, wide, 2),
        (3, 1, [0, 1, -1, 8191, -8191], 2),
        (0, 1, wide, 2),
    ):
        with case(encoding, count, version):
            random = np.random.default_rng(encoding)
            fields = {
                "loopIteration": Field(list(range(200)), (0, 1), (6, 9), 0),
                "time": Field(list(range(0, 2000, 10)), (0, 1), (1, 0), 0),
            } | {
                f"debug[{i}]": Field(random.choice(values, 200).tolist(), (0, 0), (0, encoding))
                for i in range(count)
            }
            data, _ = predicted_blackbox(fields, version=version)
            check(read_frames(data, 201), fields, np.arange(200))


def test_behind_a_damaged_frame_numbers_count_from_the_next_key_frame_on(case):
    """What was lost is a gap, and no wrong number is read."""
    fields = flight_fields(COUNT)
    whole, places = predicted_blackbox(fields)
    for row, lost in ((100, 1), (101, 2), (I_INTERVAL * 7, 3), (230, 40)):
        with case(row, lost):
            at = places[row] + 2
            data = whole[:at] + whole[at + lost :]
            key = -(-(row + 1) // I_INTERVAL) * I_INTERVAL
            found = read_frames(data, 10 * COUNT)
            check(found, fields, np.r_[0:row, key:COUNT])
            assert f"behind frame {row}" in found.damage
            assert found.damage.number == 1


def test_a_frame_whose_time_is_far_off_is_damaged(case):
    """Its end may look right by chance; those with differences to it are left out, too."""
    for row, step in ((100, 20_000_000), (100, -1000)):
        with case(step):
            fields = flight_fields(COUNT, begin_us=10**6)
            time = list(fields["time"].values)
            time[row] += step
            fields["time"] = replace(fields["time"], values=time)
            found = read_frames(predicted_blackbox(fields)[0], 10 * COUNT)
            check(found, fields, np.r_[0:row, 7 * I_INTERVAL : COUNT])
            assert f"behind frame {row}" in found.damage


def test_damage_without_a_frame_between_is_one_place():
    """A damaged frame, and a pause that begins at the next key frame: one gap."""
    begin, pause = 7 * I_INTERVAL, 10**6
    fields = flight_fields(COUNT)
    pause_flight(fields, begin, pause)
    whole, places = predicted_blackbox(fields)
    found = read_frames(whole[: places[100] + 2] + whole[places[100] + 3 :], 10 * COUNT)
    rows = np.r_[0:100, begin + I_INTERVAL : COUNT]
    np.testing.assert_array_equal(
        found.fields["gyroADC[0]"], np.array(fields["gyroADC[0]"].values)[rows]
    )
    assert found.damage.number == 1


def test_a_damaged_end_is_told(case):
    """But neither a frame that was cut nor the bytes of an empty chip."""
    fields = flight_fields(50)
    for end, told in (
        (b"P\x01", ""),
        (b"P" + b"\xff" * 5000, ""),
        (b"\x81\x82" * 500, "up to frame 49"),
    ):
        with case(end[:3], len(end)):
            found = read_frames(predicted_blackbox(fields, end=end)[0], 500)
            assert (told in found.damage) if told else found.damage == ""


def test_frames_that_are_lost_are_a_gap_and_a_remark(tmp_path):
    fields = flight_fields(COUNT)
    whole, places = predicted_blackbox(fields)
    path = tmp_path / "a.bbl"
    path.write_bytes(whole[: places[200] + 1] + whole[places[203] :])
    flight = read_blackbox(path)
    gyro = flight["imu.angular_velocity.x"]
    assert gyro.gaps == ((pytest.approx(199 * 500e-6), pytest.approx(208 * 500e-6)),)
    assert any("left out there" in each for each in flight.remarks)


def test_events_and_other_frames_do_not_disturb(case):
    """Slow fields and positions hold from their frame on, those of positions from the home."""
    fields = flight_fields(COUNT)
    slow = [
        "Field S name:flightModeFlags,failsafePhase",
        "Field S signed:0,0",
        "Field S predictor:0,0",
        "Field S encoding:1,7",
    ]
    with pytest.raises(ValueError, match="more fields than the frame"):
        read_frames(predicted_blackbox(fields, extra=slow)[0], COUNT)
    slow[-1] = "Field S encoding:1,1"
    places = [
        *(f"Field H {name}:{text}" for name, text in (("name", "GPS_home[0],GPS_home[1]"),)),
        "Field H predictor:0,0",
        "Field H encoding:0,0",
        "Field G name:time,GPS_numSat,GPS_coord[0],GPS_coord[1],GPS_altitude",
        "Field G predictor:10,0,7,7,0",
        "Field G encoding:1,1,0,0,1",
    ]
    home, away = (487654321, -123456789), (-1200, 345)
    between = {
        20: b"E\x1e" + unsigned(0x50) + unsigned(0x45),  # flight mode: bytes as P and E
        40: b"S" + unsigned(3) + unsigned(1),
        41: b"E\x0d\x05" + vb(-40),  # adjustments
        42: b"E\x0d\x85IPSG",
        43: b"E\x00" + unsigned(73 << 7),
        60: b"H" + vb(home[0]) + vb(home[1]),
        64: b"G" + unsigned(77) + unsigned(14) + vb(away[0]) + vb(away[1]) + unsigned(73),
        96: b"E\x0e" + unsigned(96) + unsigned(96 * 500),
        300: b"E\x0f" + unsigned(69),
    }
    data, _ = predicted_blackbox(fields, extra=[*slow, *places], between=between)
    found = read_frames(data, 10 * COUNT)
    check(found, fields, np.arange(COUNT))
    assert found.damage == ""
    rows = np.arange(COUNT)
    mode = np.where(rows >= 40, 3.0, np.nan)
    np.testing.assert_array_equal(found.fields["flightModeFlags"], mode)
    for i in range(2):
        place = np.where(rows >= 64, float(home[i] + away[i]), np.nan)
        np.testing.assert_array_equal(found.fields[f"GPS_coord[{i}]"], place)


def test_a_log_goes_on_behind_a_pause(case):
    """The event states the number of the control update and the time; without it, two key frames
    that fit each other do."""
    begin, pause = 10 * I_INTERVAL, 10**6
    fields = flight_fields(COUNT)
    pause_flight(fields, begin, pause)
    resume = b"E\x0e" + unsigned(begin + pause) + unsigned(500 * (begin + pause))
    for between, lost in (({begin: resume}, 0), ({}, I_INTERVAL)):
        with case(lost):
            data, _ = predicted_blackbox(fields, between=between)
            found = read_frames(data, 10 * COUNT)
            rows = np.r_[0:begin, begin + lost : COUNT]
            for name in ("time", "gyroADC[0]"):
                expected = np.array(fields[name].values)[rows]
                np.testing.assert_array_equal(found.fields[name], expected)


def test_a_damaged_event_of_a_pause_does_not_count():
    """The next key frame follows the frames before it, not the number in the event."""
    fields = flight_fields(COUNT)
    event = b"E\x0e" + unsigned(10**6) + unsigned(10**9) + b"\x01"
    data, _ = predicted_blackbox(fields, between={100: event})
    found = read_frames(data, 10 * COUNT)
    check(found, fields, np.r_[0:100, 7 * I_INTERVAL : COUNT])
    assert found.damage.number == 1


def test_headers_with_any_letters_are_all_read(tmp_path):
    """A craft's name in UTF-8 does not end the headers."""
    fields = flight_fields(50)
    data, _ = predicted_blackbox(
        fields,
        extra=["Craft name:Glühwürmchen ✈", "no colon", "Board:BEEF"],
        headers={"features": "-1,2"},
    )
    found = read_frames(data, 50)
    assert found.headers["Craft name"] == "Glühwürmchen ✈" and found.headers["Board"] == "BEEF"
    assert not any("Field" in each for each in found.headers)
    assert found.headers["motorOutput"] == [158, 2047] and found.headers["features"] == [-1, 2]
    check(found, fields, np.arange(50))


def test_a_log_without_a_whole_frame_is_empty(tmp_path, case):
    whole, places = predicted_blackbox(flight_fields(50))
    path = tmp_path / "a.bbl"
    for rest in (b"", b"P" * 5000, b"\xff" * 5000, whole[places[0] : places[1] - 1]):
        with case(rest[:5]):
            path.write_bytes(whole[: places[0]] + rest)
            with pytest.raises(WorkbenchError, match="fewer than two frames"):
                read_blackbox(path)


def test_headers_that_do_not_say_how_to_read_are_a_sentence(case):
    fields = flight_fields(50)
    whole, _ = predicted_blackbox(fields)
    for old, new, why in (
        (b"Field I name", b"Field I names", "do not name the fields"),
        (b"Field P encoding:9", b"Field P encoding:9,9", "different numbers"),
        (b"Field P predictor:6", b"Field P predictor:99", "predictor 99"),
        (b"Field P encoding:9", b"Field P encoding:4", "encoding 4"),
        (b"Field P predictor:6", b"Field P predictor:x", "whole numbers"),
        (b"H vbatref:1640", b"H vbatref:1" + b"0" * 400, "whole numbers"),
        (b"H Data version:2\n", b"H " + b"a" * 10_001 + b"\n", "more than 10 kB"),
        (b"Field I name:", b"Field I name:" + b"a," * 300, "more than 256"),
    ):
        assert whole.count(old) == 1
        with case(new[:40]), pytest.raises(ValueError, match=why):
            read_frames(whole.replace(old, new, 1), 50)


def test_numbers_in_whole_bytes_are_those_of_the_format():
    """By hand: codes 0, 1 and 3 of 1, 2 and 4 bytes from the low bits on, low bytes first."""
    assert whole_bytes([-1, 256, 2**24]).hex() == "f4ff000100000001"
