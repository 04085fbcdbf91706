"""Bounds on what an attacked function may take, and a watch on the files that it opens."""

import contextlib
import faulthandler
import os
import resource
import signal
import sys
from pathlib import Path

MOST_MEMORY = 1_000_000_000
"""Bytes that one thing may take beyond what the process has mapped already."""

MOST_SECONDS = 5.0
"""Seconds that one thing may take."""


class TooSlowError(BaseException):
    """No Exception, so that nothing that is attacked can catch it."""


def mapped():
    """Bytes of memory that this process has mapped, taken or not."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def limit_memory(more=MOST_MEMORY):
    """From now on the process may map so much more, and not a byte beyond: MemoryError."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (mapped() + more, hard))


@contextlib.contextmanager
def within(seconds=MOST_SECONDS):
    """TooSlowError after so many seconds of processor time; code that never comes back to Python is killed later on.

    It is the process's own time that counts, so that a busy machine does not matter.
    """

    fired = []

    def stop(*_):
        fired.append(True)
        raise TooSlowError

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    faulthandler.dump_traceback_later(60 * seconds, exit=True)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        faulthandler.cancel_dump_traceback_later()
    if fired:  # and something caught it all the same
        raise TooSlowError


class Watch:
    """Which files were opened, by Python, between `start` and `stop`. There is one for a process: `WATCH`."""

    def __init__(self):
        self.opened = None
        self.hooked = False

    def start(self):
        if not self.hooked:  # a hook cannot be taken off again
            sys.addaudithook(self._hook)
            self.hooked = True
        self.opened = []

    def stop(self):
        """The paths, absolute and with links resolved."""
        opened, self.opened = self.opened, None
        return [os.path.realpath(path) for path in opened]

    def _hook(self, event, arguments):
        if self.opened is not None and event in ("open", "os.listdir", "os.scandir"):
            path = arguments[0]
            if isinstance(path, (str, bytes, os.PathLike)):
                self.opened.append(os.fsdecode(path))


WATCH = Watch()
