"""Twist commands sent while the robot moves, which stop by themselves if no new one arrives."""

from __future__ import annotations

import math
import threading
import time
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_cap, checked_parameter
from robust_ik.control.tasks.pose_feedback import capped
from robust_ik.control.tasks.task_arguments import one_vector
from robust_ik.control.tasks.twist import TwistTask


class TwistCommand:
    """The last twist that was sent, as long as it is recent: a watchdog between a joystick and a robot.

    For `timeout` seconds after it was sent a twist counts in full; over the next `ramp` seconds it falls linearly to
    zero. After that, and before anything is sent, it is zero. One thread may send while another takes tasks.

    Times are seconds of one clock that does not jump; default `time.monotonic`. A twist whose time is in the future by
    more than `timeout`, as with two different clocks, does not count either.
    """

    def __init__(
        self,
        timeout: float = 0.2,
        ramp: float = 0.1,
        max_linear: float = math.inf,
        max_angular: float = math.inf,
        *,
        frame: str | None = None,
        reference: Literal["local_world_aligned", "local"] = "local_world_aligned",
        rows: tuple[str, ...] | None = None,
        weight: float = 1.0,
    ) -> None:
        """A command of zero.

        Args:
            timeout: Time for which a twist counts in full, s.
            ramp: Time in which it then falls to zero, s; 0 for at once.
            max_linear: Cap on the length of the linear part, m/s.
            max_angular: Cap on the length of the angular part, rad/s.
            frame: See `TwistTask`.
            reference: See `TwistTask`.
            rows: See `TwistTask`.
            weight: See `Task`.
        """
        self.timeout = checked_parameter("timeout", timeout, above=0)
        self.ramp = checked_parameter("ramp", ramp, least=0)
        self.max_linear = checked_cap("max_linear", max_linear)
        self.max_angular = checked_cap("max_angular", max_angular)
        self._task = TwistTask(np.zeros(6), frame, reference, rows=rows, weight=weight)
        self._lock = threading.Lock()
        self._sent: tuple[Array, float] | None = None

    def send(self, twist: ArrayLike, now: float | None = None) -> None:
        """Replaces the last twist by a new one.

        Args:
            twist: (6,), linear in m/s then angular in rad/s; longer parts are cut to the caps.
            now: The present time, s.

        Raises:
            InputError: It is no twist, or holds NaN; the last one then remains, as long as it is recent.
        """
        checked = one_vector("twist", twist, 6)
        limited = np.concatenate([capped(checked[:3], self.max_linear), capped(checked[3:], self.max_angular)])
        sent = limited, _clock(now)
        with self._lock:
            self._sent = sent

    def twist(self, now: float | None = None) -> Array:
        """The twist that is in force at `now`, (6,)."""
        moment = _clock(now)
        with self._lock:
            sent = self._sent
        if sent is None:
            return np.zeros(6)
        late = abs(moment - sent[1]) - self.timeout
        if late <= 0:
            return sent[0].copy()
        return sent[0] * (1 - late / self.ramp) if late < self.ramp else np.zeros(6)

    def task(self, now: float | None = None) -> TwistTask:
        """The task for that twist."""
        task = self._task
        return TwistTask(self.twist(now), task.frame, task.reference, rows=task.rows, weight=task.weight)


def _clock(now: float | None) -> float:
    return time.monotonic() if now is None else checked_parameter("now", now)
