"""The commands that wait for a session: few, since later ones replace earlier ones that they make needless."""

from __future__ import annotations

import threading
from collections import deque

from robust_ik.display.live.live_commands import LiveCommand

MOST_WAITING = 32
"""Most commands that wait. Chosen: nobody presses as many buttons before the first has acted; others are dropped."""


class WaitingCommands:
    """A short queue between the threads that read messages and the one that acts on them."""

    def __init__(self) -> None:
        self._commands: deque[LiveCommand] = deque()
        self._changed = threading.Condition()
        self._closed = False

    def put(self, command: LiveCommand) -> bool:
        """Adds a command, in place of the last one if that is of the same kind; whether there was room for it."""
        with self._changed:
            last = self._commands[-1] if self._commands else None
            if last is not None and command.replaced is not None and command.replaced == last.replaced:
                self._commands[-1] = command
            elif len(self._commands) >= MOST_WAITING:
                return False
            else:
                self._commands.append(command)
            self._changed.notify()
            return True

    def take(self) -> LiveCommand | None:
        """Waits for the next command; None after `close`."""
        with self._changed:
            self._changed.wait_for(lambda: self._commands or self._closed)
            return None if self._closed else self._commands.popleft()

    @property
    def empty(self) -> bool:
        """Whether nothing is waiting."""
        return not self._commands

    @property
    def closed(self) -> bool:
        """Whether `close` was called."""
        return self._closed

    def close(self) -> None:
        """Ends all waiting."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
