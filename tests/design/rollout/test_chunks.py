import threading
import time

import pytest

from workbench.design.rollout.chunks import LARGEST, run_chunks


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 5 * LARGEST + 1])
def test_every_piece_is_done_once(count, threads):
    done: list[int] = []
    assert run_chunks(lambda first, last: done.extend(range(first, last)), count, threads) == count
    assert sorted(done) == list(range(count))


@pytest.mark.parametrize("threads", [1, 2])
def test_progress_rises_to_all_of_it(threads):
    shares: list[float] = []
    run_chunks(lambda first, last: None, 100, threads, shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) > 5


@pytest.mark.parametrize("threads", [1, 2])
def test_a_stop_leaves_what_has_not_begun(threads):
    done: set[int] = set()
    asked = 0
    many = 1000 * LARGEST

    def work(first: int, last: int) -> None:
        time.sleep(0.001)  # all of them would take long enough to notice a stop
        done.update(range(first, last))

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked == 3

    count = run_chunks(work, many, threads, None, stop)
    assert done == set(range(count))
    assert 3 * LARGEST <= count < many


def test_two_threads_work_side_by_side():
    """Each waits for the other: alone neither would come to an end."""
    both = threading.Barrier(2, timeout=10.0)
    assert run_chunks(lambda first, last: both.wait() and None, 2, 2) == 2


def test_a_failure_comes_to_the_caller():
    def work(first: int, last: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_chunks(work, 40, 2)
