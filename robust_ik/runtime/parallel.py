"""Runs many independent pieces of work here, in processes or on a cluster, with the same results to the last bit.

A piece is a function of its argument alone. Its random numbers come from a seed in the argument, and the split into
pieces does not depend on the workers. So it does not matter which worker runs a piece, in what order, or how often.
"""

from __future__ import annotations

import multiprocessing
import signal
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import closing, contextmanager
from queue import SimpleQueue
from typing import Any, TypeVar

import numpy as np

from robust_ik.checks.public_arguments import check_type
from robust_ik.errors import InputError
from robust_ik.runtime.progress import ProgressCallback

Piece = TypeVar("Piece")
Result = TypeVar("Result")

LOST = (BrokenExecutor, CancelledError, OSError, EOFError)
"""Exceptions of a future whose worker, or the connection to it, is lost. A piece may raise one of them itself: that
shows when the piece is run again.
"""
KILLED = "KilledWorker"
"""Name of dask's exception for a piece that several workers died of; compared by name, since dask may be missing."""


def run_pieces(
    function: Callable[[Piece], Result],
    pieces: Iterable[Piece],
    executor: Executor | None = None,
    progress: ProgressCallback | None = None,
) -> list[Result]:
    """The results function(piece) of all pieces, in order.

    A piece that is lost because its worker died is run again in this process, and a warning says so.

    Args:
        function: A function of one argument that depends on nothing else; processes must be able to import it.
        pieces: Its arguments: at most thousands, each a tenth of a second's work or more, since each is sent alone.
        executor: The executor that runs the pieces: any `concurrent.futures.Executor`, for example `dask.distributed`'s
            `client.get_executor()`. By default the pieces run in this process, one after the other.
        progress: Called with (pieces done, pieces in all) after each piece, in this thread.

    Raises:
        InputError: The executor is not a `concurrent.futures.Executor`.
        Exception: What a piece raised. As with Ctrl-C, pieces that have not begun are then cancelled.
    """
    if executor is not None and not isinstance(executor, Executor):
        raise InputError(f"executor must be a concurrent.futures.Executor or None, got {executor!r}")
    check_type("progress", progress, "Callable | None")
    todo = list(pieces)
    results: dict[int, Result] = {}
    with closing(_finished(function, todo, executor)) as finished:
        for index, result in finished:
            results[index] = result
            if progress is not None:
                progress(len(results), len(todo))
    return [results[index] for index in range(len(todo))]


def _finished(
    function: Callable[[Piece], Result], todo: Sequence[Piece], executor: Executor | None
) -> Generator[tuple[int, Result], None, None]:
    """Results with the indices of their pieces, in the order in which they finish."""
    done = set()
    if executor is not None:
        with closing(_sent(function, todo, executor)) as sent:
            for index, result in sent:
                done.add(index)
                yield index, result
        if len(done) < len(todo):
            lost = f"{len(todo) - len(done)} of {len(todo)} pieces were lost with their workers"
            warnings.warn(f"{lost}: they are done again in this process", RuntimeWarning, stacklevel=3)
    for index, piece in enumerate(todo):
        if index not in done:
            yield index, function(piece)


def _sent(
    function: Callable[[Piece], Result], todo: Sequence[Piece], executor: Executor
) -> Generator[tuple[int, Result], None, None]:
    """Results from an executor, without those that it loses."""
    places: dict[Future[Result], int] = {}
    finished: SimpleQueue[Future[Result]] = SimpleQueue()
    try:
        for index, piece in enumerate(todo):
            try:
                future = executor.submit(function, piece)
            except BrokenExecutor:
                break
            places[future] = index
            # Not `as_completed`: it waits for ever for a future that another thread's shutdown has cancelled.
            future.add_done_callback(finished.put)
        for _ in range(len(places)):
            future = finished.get()
            try:
                result = future.result()
            except Exception as error:
                if isinstance(error, LOST) or type(error).__name__ == KILLED:
                    continue
                raise
            yield places[future], result
    finally:
        for future in places:
            future.cancel()


def chunk_sizes(count: int, most: int) -> list[int]:
    """The count split into parts of `most` and a rest: the same for every number of workers."""
    return [min(most, count - first) for first in range(0, count, most)]


def seed_of(rng: np.random.Generator | int | None, default: int = 0) -> int:
    """The seed from which the seeds of pieces are derived.

    Args:
        rng: A seed, a generator to draw one from, or None.
        default: The seed if `rng` is None.

    Raises:
        InputError: `rng` is none of these.
    """
    if isinstance(rng, np.random.Generator):
        return int(rng.integers(2**31))
    if rng is None:
        return default
    if isinstance(rng, bool) or not isinstance(rng, (int, np.integer)) or rng < 0:
        raise InputError(f"rng must be a seed of at least 0 or a numpy Generator, got {rng!r}")
    return int(rng)


@contextmanager
def process_pool(workers: int) -> Iterator[Executor | None]:
    """A pool of `workers` processes on this machine while the context lasts; None, for this process, if `workers` is 1.

    Raises:
        InputError: `workers` is not a whole number of at least 1.
    """
    if isinstance(workers, bool) or not isinstance(workers, (int, np.integer)) or workers < 1:
        raise InputError(f"workers must be a whole number of at least 1, got {workers!r}")
    if workers == 1:
        yield None
        return
    # Spawned, not forked: a fork while another thread works may hang.
    context = multiprocessing.get_context("spawn")
    pool = _Pool(int(workers), mp_context=context, initializer=_leave_interrupts_to_the_caller)
    try:
        yield pool
    finally:
        pool.end()


class _Pool(ProcessPoolExecutor):
    """A process pool whose processes end with the context, also after an error."""

    def submit(self, *given: Any, **options: Any) -> Future[Any]:
        """As in the base class, with Ctrl-C blocked while a process starts: the process inherits the blocked signal."""
        if not hasattr(signal, "pthread_sigmask"):
            return super().submit(*given, **options)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().submit(*given, **options)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def end(self) -> None:
        """Ends the processes; those that are still at work are terminated, since their results are not needed."""
        processes = list((getattr(self, "_processes", None) or {}).values())
        busy = bool(getattr(self, "_pending_work_items", None))
        self.shutdown(wait=not busy, cancel_futures=True)
        if busy:
            for process in processes:
                process.terminate()
            for process in processes:
                process.join()


def _leave_interrupts_to_the_caller() -> None:
    """Ignores Ctrl-C in a worker: it reaches every process of the terminal, and the parent cancels the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
