"""The times of samples: by the clock alone on many random faults, and by every reader."""

from collections.abc import Callable

import numpy as np
import pytest

from tests.extras.flightdata.foreign_files import WRITERS, read_here
from workbench.common.flight import Flight, LogRemark
from workbench.common.series import make_series
from workbench.extras.flightdata.readers.clock import RESTART_GAP_S, read_clock, stamps_of
from workbench.extras.flightdata.readers.stamped_stream import Stamps

PERIOD = 2000
"""Of the samples [us]."""
COUNT = 400


class Faulty:
    """The stamps of an even log after a fault.

    Attributes:
        stamps: (m) [us].
        samples: (m) number of each sample.
        kept: samples whose times must be found.
        parts: first samples of parts whose distance in time is lost.
        told: number of samples that a remark must state; None if nothing was lost.
        slack: of the times [us].
    """

    def __init__(self, random: np.random.Generator) -> None:
        self.begin = int(random.integers(0, 3_000_000_000))
        self.stamps = self.begin + PERIOD * np.arange(COUNT)
        self.samples = np.arange(COUNT)
        self.kept = np.arange(COUNT)
        self.parts: list[int] = [0]
        self.told: int | None = None
        self.slack = 1.0

    def lose(self, rows: np.ndarray) -> None:
        """Let some rows be missing in the file."""
        self.stamps, self.samples = np.delete(self.stamps, rows), np.delete(self.samples, rows)
        self.kept = self.samples


def shifted(random: np.random.Generator) -> Faulty:
    return Faulty(random)


def cut(random: np.random.Generator) -> Faulty:
    faulty = Faulty(random)
    begin = int(random.integers(0, COUNT - 100))
    faulty.lose(np.arange(begin, begin + int(random.integers(1, 90))))
    return faulty


def wrapped(random: np.random.Generator) -> Faulty:
    faulty = Faulty(random)
    at = int(random.integers(1, COUNT))
    faulty.stamps = (
        2**32 + PERIOD * (np.arange(COUNT) - at) + int(random.integers(PERIOD))
    ) % 2**32
    return faulty


def restarted(random: np.random.Generator) -> Faulty:
    faulty = Faulty(random)
    at = int(random.integers(50, COUNT - 50))
    faulty.stamps[at:] -= faulty.stamps[at] - int(random.integers(0, 3 * PERIOD))
    faulty.begin = faulty.stamps[0]
    faulty.parts = [0, at]
    faulty.told = COUNT - at
    if faulty.stamps[0] < faulty.stamps[-1]:  # the clock restarts later than it began
        faulty.stamps[:at] += 10_000_000
    return faulty


def stepped_back(random: np.random.Generator) -> Faulty:
    faulty = Faulty(random)
    at = int(random.integers(100, COUNT - 50))
    faulty.stamps = 3_000_000 + PERIOD * np.arange(COUNT)
    faulty.stamps[at:] -= int(random.integers(10, 90)) * PERIOD
    faulty.parts = [0, at]
    faulty.told = COUNT - at
    return faulty


def repeated(random: np.random.Generator) -> Faulty:
    """Some rows come twice."""
    faulty = Faulty(random)
    rows = np.sort(random.choice(COUNT, 9, replace=False))
    faulty.stamps = np.insert(faulty.stamps, rows, faulty.stamps[rows])
    faulty.samples = np.insert(faulty.samples, rows, faulty.samples[rows])
    faulty.told = 9
    return faulty


def coarse(random: np.random.Generator) -> Faulty:
    """Two or more samples share each stamp."""
    faulty = Faulty(random)
    step = PERIOD * int(random.integers(2, 6))
    faulty.stamps = faulty.stamps[0] + step * (np.arange(COUNT) * PERIOD // step)
    faulty.slack = step
    faulty.told = int((np.diff(faulty.stamps) == 0).sum())
    return faulty


def wild(random: np.random.Generator) -> Faulty:
    """One stamp is any number."""
    faulty = Faulty(random)
    at = int(random.integers(0, COUNT))
    away = int(random.integers(10**9, 4 * 10**9))
    faulty.stamps[at] = faulty.stamps[at] + away if faulty.stamps[at] < away else 0
    faulty.kept = np.delete(faulty.kept, at)
    faulty.told = 1
    return faulty


FAULTS: tuple[Callable[[np.random.Generator], Faulty], ...] = (
    shifted,
    cut,
    wrapped,
    restarted,
    stepped_back,
    repeated,
    coarse,
    wild,
)


def check(faulty: Faulty, time: np.ndarray, samples: np.ndarray, remarks: tuple[str, ...]) -> None:
    """Check the times [s] of samples: right in each part, or a remark with number and place."""
    assert set(samples) == set(faulty.kept), "samples are missing"
    assert len(samples) == len(set(samples)), "samples are there twice"
    assert (np.diff(time) > 0.0).all()
    edges = [*faulty.parts, COUNT]
    for begin, end in zip(edges[:-1], edges[1:], strict=True):
        part = (samples >= begin) & (samples < end)
        true = 1e-6 * PERIOD * samples[part]
        found = time[part]
        np.testing.assert_allclose(
            found - found[0], true - true[0], atol=1e-6 * faulty.slack + 2e-9
        )
    assert time[0] == pytest.approx(0.0, abs=1e-9)
    told = [each for each in remarks if isinstance(each, LogRemark) and each.place.count(" ")]
    if faulty.told is None:
        assert not told
    else:
        assert len(told) == 1, told
        # Behind a restart there are those of a slower topic, too.
        more = faulty.told // 7 + 1 if "goes back" in told[0] else 0
        assert faulty.told <= (told[0].number or 0) <= faulty.told + more, told
        assert all(str(each.number) in each and each.place in each for each in told)


@pytest.mark.parametrize("fault", FAULTS)
def test_the_clock_finds_times_or_says_which_it_cannot(fault, case):
    for seed in range(60):
        with case(seed):
            faulty = fault(np.random.default_rng(seed))
            values = faulty.samples.astype(float)
            clock = read_clock({"a": stamps_of(faulty.stamps, [values])}, 1e-6)
            kept = np.isfinite(clock.times["a"])
            check(faulty, clock.times["a"][kept], faulty.samples[kept], clock.remarks)
            assert len(clock.breaks) == len(faulty.parts) - 1
            assert clock.end == clock.times["a"][kept][-1]


@pytest.mark.parametrize("copied", [False, True])
def test_of_two_samples_with_one_stamp_only_a_copy_is_left_out(copied):
    """One of 400 has the stamp of the one before it: another sample is of the next period."""
    ticks, values = PERIOD * np.arange(float(COUNT)), np.sin(np.arange(float(COUNT)))
    ticks[101], values[101] = ticks[100], values[100] if copied else values[101]
    clock = read_clock({"a": stamps_of(ticks, (values, 0.0 * values))}, 1e-6)
    wanted = 1e-6 * PERIOD * np.arange(COUNT)
    wanted[101] = np.nan if copied else wanted[101]
    assert clock.times["a"] == pytest.approx(wanted, abs=1e-9, nan_ok=True)
    said = "repeat the one before" if copied else "share the time of the one before, spread"
    assert [said in str(each) for each in clock.remarks] == [True]


@pytest.mark.parametrize("write", WRITERS)
def test_every_reader_finds_times_or_says_which_it_cannot(write, tmp_path, case):
    for fault in FAULTS:
        with case(fault.__name__):
            faulty = fault(np.random.default_rng(7))
            path = write(tmp_path, faulty.stamps, 1.0 + faulty.samples)
            flight = read_here(path)
            path.unlink()
            gyro = flight["imu.angular_velocity.x"]
            samples = np.rint(np.degrees(gyro.values) - 1.0).astype(int)
            np.testing.assert_allclose(np.degrees(gyro.values) - 1.0, samples, atol=1e-3)
            remarks = tuple(each for each in flight.remarks if of_gyro(each, flight))
            check(faulty, gyro.time, samples, remarks)
            for first in faulty.parts[1:]:  # nothing is interpolated across a restart
                (row,) = np.flatnonzero(samples == first)
                assert (gyro.time[row - 1], gyro.time[row]) in gyro.gaps
            if "battery.voltage" in flight:  # the slow topic stays beside the fast one
                slow = flight["battery.voltage"]
                numbers = np.rint((slow.values - 16.0) / 0.001).astype(int)
                beside = dict(zip(samples.tolist(), gyro.time.tolist(), strict=True))
                rows = faulty.samples[::7][numbers]
                pairs = [
                    (t, beside[i]) for t, i in zip(slow.time, rows, strict=True) if i in beside
                ]
                times = np.array(pairs)
                np.testing.assert_allclose(
                    times[:, 0], times[:, 1], atol=1e-6 * faulty.slack + 2e-9
                )


def of_gyro(remark: str, flight: Flight) -> bool:
    """Return whether a remark is on the times of the gyro; the slow topic has its own."""
    return "battery_status" not in remark and "BAT" not in remark


def test_streams_restart_together_and_stay_aligned():
    """A slow stream may not see the step itself, but is moved as the fast ones are."""
    fast = np.concatenate([np.arange(0.0, 10.0, 0.01) + 50.0, np.arange(0.0, 5.0, 0.01) + 57.0])
    slow = np.concatenate([np.arange(0.0, 10.0, 2.5) + 50.0, np.arange(0.0, 5.0, 2.5) + 57.001])
    late = np.array([52.0, 60.5])  # its clock goes on
    places = {
        "fast": np.arange(1500.0),
        "slow": np.array([0.5, 250.5, 500.5, 750.5, 1000.5, 1250.5]),
        "late": np.array([200.5, 1350.5]),
    }
    streams = {
        name: Stamps(stamps, places[name], np.zeros(len(stamps), bool))
        for name, stamps in (("fast", fast), ("slow", slow), ("late", late))
    }
    clock = read_clock(streams, 1.0)
    later = np.where(np.arange(1500) < 1000, 0.0, RESTART_GAP_S - 0.01)
    np.testing.assert_allclose(clock.times["fast"], 0.01 * np.arange(1500) + later, atol=1e-9)
    times = [0.0, 2.5, 5.0, 7.5, 10.991, 13.491]
    np.testing.assert_allclose(clock.times["slow"], times, atol=1e-9)
    np.testing.assert_allclose(clock.times["late"], [2.0, 14.49], atol=1e-9)
    assert [each.number for each in clock.remarks] == [503]
    assert clock.breaks == (pytest.approx((9.99, 9.99 + RESTART_GAP_S)),)
    # so that even a stream whose samples are farther apart than that has a gap there
    slow = make_series("a.b", "V", clock.times["slow"], np.ones(6), breaks=clock.breaks)
    assert slow.gaps == (pytest.approx((7.5, 10.991)),)


def test_a_stream_may_step_back_alone():
    """The other stream goes on: it is no restart of the log's clock."""
    good = np.arange(0.0, 10.0, 0.01)
    bad = good.copy()
    bad[500:] -= 3.0
    streams = {
        name: Stamps(stamps, np.arange(1000) + place, np.zeros(1000, bool))
        for name, stamps, place in (("good", good, 0.1), ("bad", bad, 0.2), ("other", good, 0.3))
    }
    clock = read_clock(streams, 1.0)
    for name in ("good", "bad"):
        np.testing.assert_allclose(clock.times[name], good, atol=1e-9)
    (remark,) = clock.remarks
    assert remark.place == "sample 501 of bad, at 5.000 s" and remark.number == 500


def test_few_samples_make_neither_a_restart_nor_an_end(case):
    """Damaged stamps at the ends, and a few of them that step back before the clock does."""
    even = 5e9 + 2000.0 * np.arange(400)
    for rows, value in (
        (0, 9e9),
        ([0, 1], [0.0, 2000.0]),
        (-1, 9e9),
        ([-2, -1], [9e9, 9e9 + 2000.0]),
        (-1, 0.0),
    ):
        with case(rows, value):
            stamps = even.copy()
            stamps[rows] = value
            clock = read_clock({"a": stamps_of(stamps)}, 1e-6)
            kept = np.isfinite(clock.times["a"])
            lost = np.zeros(400, bool)
            lost[rows] = True
            np.testing.assert_array_equal(~kept, lost)
            np.testing.assert_allclose(np.diff(clock.times["a"][kept]), 2e-3, atol=1e-9)
            assert [each.number for each in clock.remarks] == [lost.sum()]
    stamps = np.concatenate([even[:200] + 5e8, [3e8, 3e8 + 2000.0], even[200:] - even[200]])
    clock = read_clock({"a": stamps_of(stamps)}, 1e-6)
    assert np.flatnonzero(np.isnan(clock.times["a"])).tolist() == [200, 201]
    assert len(clock.breaks) == 1 and clock.end == pytest.approx(398 * 2e-3 + RESTART_GAP_S)


def test_counters_of_all_units_overflow(case):
    """Unsigned and signed ones of 32 bits, in their own unit or in seconds."""
    even = np.arange(500)
    for tick, stamps in (
        (1e-6, (2000.0 * even - 3e5) % 2**32),
        (1e-6, (2000.0 * even - 3e5 + 2**31) % 2**32 - 2**31),
        (1e-3, (2.0 * even - 300.0 + 2**31 + 2**31) % 2**32 - 2**31),
        (1.0, (2e-3 * even - 0.3) % (2**32 * 1e-6)),
        (1.0, (2e-3 * even - 0.3) % (2**32 * 1e-3)),
    ):
        with case(tick, stamps[0]):
            clock = read_clock({"a": stamps_of(stamps)}, tick)
            np.testing.assert_allclose(clock.times["a"], 2e-3 * even, atol=1e-6)
            assert clock.remarks == () and clock.breaks == ()


def test_samples_out_of_order_lose_few_others(case):
    """Of two samples that came the other way round one is left out, whatever their number."""
    for seed in range(5):
        with case(seed):
            random = np.random.default_rng(seed)
            stamps = 2000.0 * np.arange(4000)
            first = 2 * random.choice(2000, 200, replace=False)
            stamps[first], stamps[first + 1] = stamps[first + 1].copy(), stamps[first].copy()
            clock = read_clock({"a": stamps_of(stamps)}, 1e-6)
            lost = np.flatnonzero(np.isnan(clock.times["a"]))
            assert len(lost) == 200 == clock.remarks[0].number and len(clock.remarks) == 1
            assert set(lost // 2) == set(first // 2)


def test_a_clock_without_any_order_is_read_in_bounded_time():
    random = np.random.default_rng(1)
    clock = read_clock({"a": stamps_of(random.uniform(0.0, 1e9, 20_000))}, 1e-6)
    time = clock.times["a"][np.isfinite(clock.times["a"])]
    lost = sum(each.number for each in clock.remarks if "goes back" not in each)
    assert (np.diff(time) > 0.0).all() and lost == 20_000 - len(time)


def test_faults_together(case):
    """Several faults in one log: nothing is silently lost or doubled."""
    for seed in range(40):
        with case(seed):
            random = np.random.default_rng(seed)
            stamps = 1e6 + 2000.0 * np.arange(600)
            stamps[400:] = 500.0 + 2000.0 * np.arange(200)
            bad = random.choice(
                np.setdiff1d(np.arange(5, 595), np.arange(390, 410)), 5, replace=False
            )
            stamps[bad] = random.choice([0.0, 4e9, 1e15, np.nan], 5)
            clock = read_clock({"a": stamps_of(stamps, [np.arange(600.0)])}, 1e-6)
            kept = np.isfinite(clock.times["a"])
            lost = sum(each.number for each in clock.remarks if "goes back" not in each)
            assert lost == np.sum(~kept) and set(np.flatnonzero(~kept)) <= set(bad)
            for part in (slice(0, 400), slice(400, 600)):
                time = clock.times["a"][part][kept[part]]
                true = 2e-3 * np.arange(600)[part][kept[part]]
                np.testing.assert_allclose(time - time[0], true - true[0], atol=1e-9)
