"""Progress of long work, shown at a terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PATIENCE = 2.0
"""Seconds after which a progress bar is shown."""

ProgressCallback = Callable[[int, int], None]
"""A callback that is called with (steps done, steps in all)."""


@contextmanager
def progress_bar(what: str) -> Iterator[ProgressCallback]:
    """A progress bar on standard error, shown only at a terminal and if the work takes longer than `PATIENCE`.

    Args:
        what: What to call the work.
    """
    if not sys.stderr.isatty():
        yield lambda done, total: None  # noqa: ARG005
        return
    from rich.console import Console  # takes 50 ms: imported only at a terminal
    from rich.progress import Progress

    from robust_ik.errors.safe_text import in_markup

    bar, began = Progress(console=Console(stderr=True, emoji=False), transient=True), time.monotonic()
    task = bar.add_task(in_markup(what), total=None)

    def told(done: int, total: int) -> None:
        if not bar.live.is_started and time.monotonic() - began > PATIENCE:
            bar.start()
        bar.update(task, completed=done, total=total)

    try:
        yield told
    finally:
        bar.stop()
