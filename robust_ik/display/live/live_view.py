"""LiveView: a session with its scene, its server and the thread that acts on what pages send."""

from __future__ import annotations

import json
import logging
import secrets
import threading
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, alone, as_array
from robust_ik.checks.public_arguments import checked
from robust_ik.display.drawings.drawn_robot import MissingMesh
from robust_ik.display.live.live_commands import LiveCommand, read_command
from robust_ik.display.live.live_page import live_body
from robust_ik.display.live.live_scene import LiveScene
from robust_ik.display.live.live_session import LiveSession, Nearby
from robust_ik.display.live.live_state import LiveState
from robust_ik.display.live.waiting_commands import WaitingCommands
from robust_ik.display.scene.live_server import LiveServer
from robust_ik.display.scene.recording_window import RecordingWindow
from robust_ik.display.scene.scene import Scene
from robust_ik.errors import InputError, RobustIKError, cut
from robust_ik.robot.robot import Robot
from robust_ik.singularities import find_singularities
from robust_ik.singularities.atlas import SingularityAtlas

TOKEN_BYTES = 24
"""Random bytes of a token. Chosen: 192 bits, which nobody guesses."""
LAST_WAIT = 10.0
"""Seconds for which `close` waits for what is being worked out. Chosen: most searches report more often."""
LOG = logging.getLogger(__name__)


class _StoppedError(Exception):
    """The view was closed while families were searched."""


@dataclass(frozen=True)
class _News:
    """What pages are told besides the state: families, and how far their search is."""

    families: tuple[dict[str, Any], ...] = ()
    searched: float = 0.0
    note: str = ""


class LiveView:
    """A page on this machine in which one moves a robot and sees what it cannot do there; see `view`.

    Attributes:
        robot: The robot.
    """

    def __init__(self, robot: Robot, q: Array, port: int, atlas: SingularityAtlas | None) -> None:
        self.robot = robot
        self.token = secrets.token_urlsafe(TOKEN_BYTES)
        self._session = LiveSession(robot, q)
        self._waiting = WaitingCommands()
        self._lock = threading.Lock()
        self._state, self._news = "", _News()
        self._server = LiveServer(RecordingWindow(), port, self)
        self._scene = LiveScene.draw(Scene(self._server), robot, q)
        self._publish(None)
        self._threads = [threading.Thread(target=self._work, name="robust_ik.live", daemon=True)]
        if atlas is None:
            self._threads.append(threading.Thread(target=self._search, name="robust_ik.families", daemon=True))
        else:
            self._learn(atlas)
        for thread in self._threads:
            thread.start()

    # ------------------------------------------------------------------------------------------ for people
    @property
    def url(self) -> str:
        """The address of the page, with the token that lets it move the robot; who knows it can."""
        return self._server.url

    @property
    def q(self) -> Array:
        """Where the robot is, (nq,)."""
        return np.array(self._session.q)

    @property
    def state(self) -> LiveState:
        """What the page says of where the robot is."""
        return self._session.state

    @property
    def atlas(self) -> SingularityAtlas | None:
        """Its singular configurations, once they are known."""
        return self._session.atlas

    @property
    def missing_meshes(self) -> tuple[MissingMesh, ...]:
        """Meshes that are replaced by stand-ins."""
        return self._scene.drawing.missing_meshes

    @checked
    def show(self, q: ArrayLike) -> None:
        """Moves the robot to a configuration, (nq,); what is beyond limits is set to them."""
        values = self.robot.joint_values(alone(as_array(q, "q", (self.robot.nq,)), "q", 1))
        self._waiting.put(LiveCommand("configuration", {"values": [float(each) for each in values]}))

    def close(self) -> None:
        """Ends the page's connection, and all that runs for it."""
        self._waiting.close()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(timeout=LAST_WAIT)
        self._server.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        where = self.url if self._server.running else "closed"
        return f"LiveView({self.robot.name!r}, {where})"

    def _repr_html_(self) -> str:
        """A frame for a notebook; a sentence once it is closed, or where this machine's ports cannot be reached."""
        if not self._server.running:
            return "<p>This view is closed: call <code>robust_ik.display.view(robot)</code> again.</p>"
        return (
            f'<iframe src="{self.url}" style="width: 100%; height: 640px; border: 0"></iframe>'
            "<p>Empty? The program that serves this page has ended, or runs on another machine.</p>"
        )

    # ------------------------------------------------------------------------------------------ for the server
    def page(self, host: str) -> str:
        """The page; see `Controls`."""
        return live_body(self.robot, self.missing_meshes, host)

    def receive(self, message: str | bytes) -> None:
        """Takes a message; one that is no command is dropped, with a line in the log."""
        try:
            command = read_command(message)
        except InputError as error:
            LOG.warning("a message from a page was dropped: %s", cut(str(error), 200))
            return
        if not self._waiting.put(command):
            LOG.warning("a message from a page was dropped: more come than can be carried out")

    def newest(self) -> list[str]:
        """The state, and what is known of families."""
        with self._lock:
            news = self._news
            told = {"kind": "families", "families": news.families, "searched": news.searched, "note": news.note}
            return [self._state, json.dumps(told)]

    # ------------------------------------------------------------------------------------------ threads
    def _work(self) -> None:
        """Carries out commands, one by one; what takes longer is told once nothing waits."""
        while (command := self._waiting.take()) is not None:
            self._session.do(command)
            self._publish(None)
            if self._waiting.empty:
                self._publish(self._session.nearby())

    def _publish(self, nearby: Nearby | None) -> None:
        session = self._session
        self._scene.show(session, nearby)
        told = {"kind": "state", "said": session.said, **session.state.plain(), "nearby": None, "solutions": None}
        told["kept"] = session.kept[:3, 3].tolist()
        if nearby is not None:
            told["nearby"] = {"words": nearby.words, "lost": nearby.lost, "index": nearby.index}
            told["nearby"] |= {"distance": nearby.distance, "values": self.robot.joint_values(nearby.q).tolist()}
        if session.solutions is not None:
            found = session.solutions
            away = np.linalg.norm(self.robot.difference(np.broadcast_to(session.q, found.q.shape), found.q), axis=-1)
            told["solutions"] = {
                "status": found.status.value,
                "away": away.tolist(),
                "singular": found.singular.tolist(),
                "beyond": len(found.beyond),
            }
        with self._lock:
            self._state = json.dumps(told, allow_nan=False)
        self._server.tell()

    def _search(self) -> None:
        try:
            self._learn(find_singularities(self.robot, progress=self._progress))
        except _StoppedError:
            return
        except RobustIKError as error:
            self._tell(_News(note=f"Families are not known: {error}", searched=1.0))

    def _progress(self, done: int, total: int) -> None:
        if self._waiting.closed:
            raise _StoppedError
        self._tell(_News(searched=min(done / max(total, 1), 0.99)))

    def _learn(self, atlas: SingularityAtlas) -> None:
        self._session.atlas = atlas
        told = tuple(
            {"words": row.words, "corank": row.corank, "within": row.within_limits, "lost": str(row.lost or "")}
            for row in atlas.strata
        )
        self._tell(_News(told, 1.0, atlas.explanation if not atlas.strata else ""))
        self._waiting.put(LiveCommand("look"))

    def _tell(self, news: _News) -> None:
        with self._lock:
            self._news = news
        self._server.tell()


@checked
def view(robot: Robot, q: ArrayLike | None = None, *, port: int = 0, atlas: SingularityAtlas | None = None) -> LiveView:
    """Opens a page on this machine in which one moves a robot and sees what it cannot do there; in a notebook, a cell.

    The server listens on 127.0.0.1 only, and only pages with the token of `url` move the robot. It is a thread of this
    program and ends with it.

    Args:
        robot: A robot with a tip.
        q: Where it begins, (nq,); default `robot.rest`.
        port: TCP port; 0 for any free one.
        atlas: Its singular configurations; by default they are searched while the page is open.

    Raises:
        InputError: The robot has no tip, or an argument is not valid.
        OSError: The port is in use.
    """
    start = robot.rest if q is None else alone(as_array(q, "q", (robot.nq,)), "q", 1)
    return LiveView(robot, start, port, atlas)
