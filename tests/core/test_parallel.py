import threading
import time

import pytest

from npm_blender.core.errors import Cancelled
from npm_blender.core.parallel import MOST, each, first_time, threads, together


@pytest.mark.parametrize("count", ["1", "2", "5"])
def test_results_come_in_the_order_of_the_pieces(count, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", count)
    assert each(lambda k: (time.sleep(0.001 * (5 - k)), k * k)[1], range(6)) == [k * k for k in range(6)]


def test_no_pieces_no_results():
    assert each(abs, []) == []


def test_pieces_run_side_by_side(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    meeting = threading.Barrier(2, timeout=10)

    def task(_):
        return meeting.wait()

    first_time(task)
    assert sorted(each(task, range(2))) == [0, 1]


def test_the_first_piece_of_new_code_runs_alone(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    running, seen = [], []

    def task(k):
        running.append(k)
        time.sleep(0.01)
        seen.append(len(running))
        running.remove(k)

    each(task, range(6))
    assert seen[0] == 1 and max(seen) > 1


def test_the_first_failure_is_raised_and_nothing_runs_on():
    def task(k):
        if k == 3:
            raise ValueError("the third")
        begun.append(k)
        time.sleep(0.005)

    begun, before = [], threading.active_count()
    with pytest.raises(ValueError, match="the third"):
        each(task, range(50))
    assert threading.active_count() == before
    assert max(begun) < 3 + MOST


@pytest.mark.parametrize("count", ["1", "2", "5"])
def test_of_two_failures_the_one_of_the_first_piece_is_raised(count, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", count)

    def task(k):
        if k == 0:
            time.sleep(0.02)
        raise ValueError(f"number {k}")

    with pytest.raises(ValueError, match="number 0"):
        each(task, range(5))


def test_steps_run_together(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    meeting = threading.Barrier(2, timeout=10)
    together(int)  # whose own code is known then
    assert together(lambda: (meeting.wait(), "one")[1], lambda: (meeting.wait(), "two")[1]) == ["one", "two"]


def test_progress_is_called_by_the_calling_thread_alone(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    told = []
    each(lambda _: time.sleep(0.001), range(30), lambda share, _: told.append((share, threading.current_thread())), "Working")
    shares, callers = zip(*told, strict=True)
    assert set(callers) == {threading.current_thread()} and list(shares) == sorted(shares) and shares[-1] < 1


def test_a_cancel_drops_the_pieces_not_begun(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    done = []

    def progress(share, message):
        assert message == "Working"
        if share > 0.05:
            raise Cancelled()

    with pytest.raises(Cancelled):
        each(lambda k: (time.sleep(0.01), done.append(k)), range(100), progress, "Working")
    assert len(done) < 50


@pytest.mark.parametrize("asked,found", [("3", 3), ("1000", MOST), ("0", None), ("all", None), ("", None), ("-2", None)])
def test_threads_follow_the_environment_where_it_names_a_number(asked, found, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", asked)
    assert threads() == found or (found is None and 1 <= threads() <= MOST)
