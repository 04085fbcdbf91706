"""Pieces of work give the same, whoever does them and whoever dies of it."""

import json
import os
import pickle
import signal
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import cache
from multiprocessing import get_context

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.runtime.parallel import chunk_sizes, process_pool, run_pieces, seed_of
from robust_ik.singularities.atlas.atlas_json import to_plain

CALLER = os.getpid()


def random_sum(piece):
    """A piece as they should be: what is random in it comes from its argument."""
    values = np.random.default_rng([7, piece]).standard_normal((60, 6, 6))
    return np.linalg.svd(values, compute_uv=False).sum(axis=0)


def deadly(piece):
    """One that kills whoever does it, unless that is the caller."""
    number, caller = piece
    if number == 3 and os.getpid() != caller:
        os.kill(os.getpid(), signal.SIGKILL)
    return random_sum(number)


def refused(piece):
    raise rik.InputError(f"piece {piece} cannot be meant")


def expected(count):
    return [random_sum(piece).tobytes() for piece in range(count)]


def bits(results):
    return [each.tobytes() for each in results]


class Scripted(Executor):
    """Does pieces at once, but those that it is told to lose."""

    def __init__(self, losses, breaks_at=None):
        self.losses, self.breaks_at, self.count = losses, breaks_at, 0

    def submit(self, function, /, *arguments, **options):
        index, self.count = self.count, self.count + 1
        if index == self.breaks_at:
            raise BrokenProcessPool("a worker died")
        future = Future()
        if index not in self.losses:
            future.set_result(function(*arguments))
        elif self.losses[index] is None:
            future.cancel()
        else:
            future.set_exception(self.losses[index])
        return future


KilledWorker = type("KilledWorker", (Exception,), {})  # dask's is known by its name


@pytest.fixture(scope="module")
def pool():
    with process_pool(2) as made:
        yield made


# ------------------------------------------------------------------------------------------------ what comes of pieces
def test_results_come_in_the_order_of_the_pieces_and_are_the_same_for_every_executor(pool):
    with ThreadPoolExecutor(3) as threads:
        for executor in (None, threads, pool):
            assert bits(run_pieces(random_sum, range(9), executor)) == expected(9)


@pytest.mark.parametrize("executor", [None, Scripted({})])
def test_no_pieces_give_no_results(executor):
    assert run_pieces(random_sum, (), executor) == []


def test_progress_is_told_as_pieces_finish_here_and_elsewhere():
    with ThreadPoolExecutor(2) as threads:
        for executor in (None, threads):
            told = []
            run_pieces(random_sum, range(5), executor, lambda *counts, told=told: told.append(counts))
            assert told == [(done, 5) for done in range(1, 6)]


def test_what_a_piece_raises_is_raised_as_it_is(pool):
    with ThreadPoolExecutor(1) as threads:
        for executor in (None, threads, pool):
            with pytest.raises(rik.InputError, match=r"^piece \d cannot be meant$"):
                run_pieces(refused, range(4), executor)


def test_an_error_of_a_piece_that_looks_like_a_lost_one_shows_when_it_is_done_again():
    def reads(piece):
        raise FileNotFoundError(piece)

    with (
        ThreadPoolExecutor(1) as threads,
        pytest.warns(RuntimeWarning, match="lost"),
        pytest.raises(FileNotFoundError, match="data"),
    ):
        run_pieces(reads, ["data"], threads)


def test_an_interruption_cancels_what_waits():
    begun, go_on = [], threading.Event()

    def waits(piece):
        begun.append(piece)
        assert piece == 0 or go_on.wait(60)

    def stop(done, total):
        raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as threads:
        with pytest.raises(KeyboardInterrupt):
            run_pieces(waits, range(50), threads, stop)
        go_on.set()
    assert len(begun) <= 2


def test_what_is_no_executor_is_refused():
    with pytest.raises(rik.InputError, match="executor must be a concurrent.futures.Executor or None, got 4"):
        run_pieces(random_sum, range(3), 4)


# ------------------------------------------------------------------------------------------------ what is lost
@pytest.mark.parametrize(
    "losses, breaks_at, lost",
    [
        ({1: BrokenProcessPool("died"), 2: BrokenProcessPool("died")}, None, 2),
        ({0: None, 4: KilledWorker()}, None, 2),
        ({5: ConnectionResetError()}, None, 1),
        ({}, 0, 6),
        ({1: BrokenProcessPool("died")}, 4, 3),
    ],
)
def test_lost_pieces_are_done_again_here_and_that_is_told(losses, breaks_at, lost):
    told = []
    with pytest.warns(RuntimeWarning, match=f"{lost} of 6 pieces were lost with their workers"):
        results = run_pieces(random_sum, range(6), Scripted(losses, breaks_at), lambda *counts: told.append(counts))
    assert bits(results) == expected(6)
    assert told == [(done, 6) for done in range(1, 7)]


def test_a_killed_worker_of_a_pool_loses_nothing_and_changes_no_bit():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as mortal:
        with pytest.warns(RuntimeWarning, match="of 8 pieces were lost"):
            results = run_pieces(deadly, [(number, CALLER) for number in range(8)], mortal)
        assert bits(results) == expected(8)
        with pytest.warns(RuntimeWarning, match="8 of 8 pieces were lost"):
            assert bits(run_pieces(random_sum, range(8), mortal)) == expected(8)


def test_a_pool_of_one_is_this_process_and_a_pool_of_none_is_refused():
    with process_pool(1) as executor:
        assert executor is None
    for workers in (0, -1, 1.5, True):
        with pytest.raises(rik.InputError, match="workers must be"), process_pool(workers):
            pass


def test_parts_add_up():
    assert chunk_sizes(1100, 500) == [500, 500, 100]
    assert chunk_sizes(500, 500) == [500]
    assert chunk_sizes(0, 500) == []


def test_seeds_are_given_drawn_or_the_default():
    assert [seed_of(5), seed_of(None), seed_of(None, 3), seed_of(np.int64(2))] == [5, 0, 3, 2]
    assert seed_of(np.random.default_rng(1)) == seed_of(np.random.default_rng(1)) > 0
    for wrong in (-1, True, 1.0, "today"):
        with pytest.raises(rik.InputError, match="rng must be"):
            seed_of(wrong)


# ------------------------------------------------------------------------------------------------ atlases
def plain(atlas):
    return json.dumps(to_plain(atlas))


def atlas_of(**options):
    return rik.find_singularities(rik.load("duleba_3r"), starts=1100, rng=4, **options)


@cache
def alone():
    return plain(atlas_of())


@pytest.mark.slow
def test_an_atlas_is_the_same_with_any_number_of_workers(pool):
    assert plain(atlas_of(executor=pool)) == alone()
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as one:
        assert plain(atlas_of(executor=one)) == alone()


@pytest.mark.slow
def test_an_atlas_extended_by_workers_is_the_same(pool):
    atlas = rik.find_singularities(rik.load("planar_2r"), starts=20)
    assert plain(atlas.extended(600, executor=pool)) == plain(atlas.extended(600))


@pytest.mark.slow
def test_progress_of_an_atlas_only_grows_and_ends(pool):
    for executor in (None, pool):
        told = []
        atlas_of(executor=executor, progress=lambda *counts, told=told: told.append(counts))
        done = [each for each, _ in told]
        assert done == sorted(done)
        assert len({total for _, total in told}) == 1
        assert told[-1][0] == told[-1][1]


@pytest.mark.slow
def test_an_atlas_loses_nothing_when_a_worker_is_killed():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as mortal:
        victim = mortal.submit(os.getpid).result()
        with pytest.warns(RuntimeWarning, match="lost with their workers"):
            found = plain(atlas_of(executor=mortal, progress=killer(victim)))
    assert found == alone()


def killer(victim):
    """Progress that kills a process when the first piece is done."""
    killed = []

    def told(done, total):
        if done >= 1 and not killed:
            killed.append(victim)
            os.kill(victim, signal.SIGKILL)

    return told


def test_an_interrupted_atlas_with_workers_is_marked(pool):
    def stop(done, total):
        if done / total > 0.3:
            raise KeyboardInterrupt

    assert atlas_of(executor=pool, progress=stop).interrupted


def test_atlases_travel_between_processes():
    atlas = rik.find_singularities(rik.load("planar_2r"), starts=50)
    back = pickle.loads(pickle.dumps(atlas))
    assert plain(back) == plain(atlas)
    assert back.robot.symbols == atlas.robot.symbols
    with pytest.raises(TypeError):
        back.robot.symbols["a1"] = 0.0


# ------------------------------------------------------------------------------------------------ a cluster
@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    # Without an address its pages would want the one port that another test's cluster may have.
    quiet = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": 60}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, **quiet) as made,
        distributed.Client(made) as client,
    ):
        client.wait_for_workers(2)
        yield made, client


@pytest.mark.slow
def test_two_dask_workers_give_the_same_atlas_to_the_last_bit(cluster):
    _, client = cluster
    assert plain(atlas_of(executor=client.get_executor())) == alone()


@pytest.mark.slow
def test_a_killed_dask_worker_loses_nothing_and_changes_no_bit(cluster):
    _, client = cluster
    victim = next(iter(client.run(os.getpid).values()))
    assert plain(atlas_of(executor=client.get_executor(), progress=killer(victim))) == alone()
    client.wait_for_workers(2)


@pytest.mark.slow
def test_a_piece_that_dask_gives_up_is_done_here(cluster, monkeypatch):
    made, client = cluster
    monkeypatch.setattr(made.scheduler, "allowed_failures", 0)
    with pytest.warns(RuntimeWarning, match="of 8 pieces were lost"):
        results = run_pieces(deadly, [(number, CALLER) for number in range(8)], client.get_executor())
    assert bits(results) == expected(8)
