"""Shows a scene to browsers on this machine while it changes, and to nobody else."""

from __future__ import annotations

import asyncio
import reprlib
import socket
import threading
from collections.abc import Sequence
from typing import Any
from urllib.parse import urlsplit

import tornado.httpserver
import tornado.iostream
import tornado.web
import tornado.websocket

from robust_ik.display.scene.html_page import live_page
from robust_ik.display.scene.meshcat_module import VIEWER_FOLDER, umsgpack
from robust_ik.display.scene.recording_window import RecordingWindow
from robust_ik.errors import InputError

HOST = "127.0.0.1"
# A page of another site could otherwise reach the server under a name of its own that it lets resolve to 127.0.0.1.
HOSTS = r"(127\.0\.0\.1|localhost)"

MOST_COMMANDS, MOST_BYTES = 4_000, 8_000_000
"""What waits for a viewer at the most: one that falls further behind gets the scene as it is by then."""
CLEARED: bytes = umsgpack.packb({"type": "delete", "path": "/meshcat"})
"""The command that takes away what scenes draw; the viewer's own grid and lights stay."""


class LiveServer:
    """Serves a window's scene from a thread of this program.

    meshcat's own server is another process, which outlives a program that is killed, and its page is offered on every
    network interface.

    Attributes:
        window: Where the scene is recorded.
        address: What it listens on, (host, port).
    """

    def __init__(self, window: RecordingWindow, port: int = 0) -> None:
        if isinstance(port, bool) or not isinstance(port, int) or not 0 <= port < 65536:
            raise InputError(f"port must be a whole number from 0 to 65535, got {reprlib.repr(port)}")
        self.window = window
        self._viewers: set[_Viewer] = set()
        self._feeds: dict[_Viewer, asyncio.Task[None]] = {}
        self._lock, self._waiting = threading.Lock(), Queue()
        listener = socket.create_server((HOST, port), backlog=128)
        listener.setblocking(False)
        self.address: tuple[str, int] = listener.getsockname()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, args=(listener,), name="robust_ik.display", daemon=True)
        self._thread.start()
        window.listen(self._forward)

    @property
    def url(self) -> str:
        """The page to watch."""
        return f"http://{HOST}:{self.address[1]}/"

    @property
    def running(self) -> bool:
        """Whether it has not been closed."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Disconnects every viewer and frees the port. Does nothing the second time."""
        if not self.running:
            return
        self.window.forget(self._forward)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()

    def _run(self, listener: socket.socket) -> None:
        asyncio.set_event_loop(self._loop)
        application = tornado.web.Application(log_function=_say_nothing)
        application.add_handlers(HOSTS, [
            (r"/", _Viewer, {"server": self}),
            (r"/static/(.*)", tornado.web.StaticFileHandler,
             {"path": str(VIEWER_FOLDER), "default_filename": "index.html"}),
        ])  # fmt: skip
        server = tornado.httpserver.HTTPServer(application)
        server.add_socket(listener)
        try:
            self._loop.run_forever()
        finally:
            self._loop.run_until_complete(self._shut_down(server))
            self._loop.close()

    async def _shut_down(self, server: tornado.httpserver.HTTPServer) -> None:
        server.stop()
        for viewer in list(self._viewers):
            viewer.close()
        await server.close_all_connections()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _forward(self, command: bytes) -> None:
        """Passes a command to every viewer; called from the program's threads, which may be faster than the server."""
        with self._lock:
            first = self._waiting.empty
            self._waiting.put(command)
        if first:
            self._loop.call_soon_threadsafe(self._pass_on)

    def _pass_on(self) -> None:
        with self._lock:
            commands = self._waiting.take()
        for viewer in list(self._viewers):
            viewer.show(commands)

    def welcome(self, viewer: _Viewer) -> None:
        """Sends the whole scene to a viewer that has just connected, and from now on every change."""
        self._viewers.add(viewer)
        viewer.show(None)
        self._feeds[viewer] = self._loop.create_task(viewer.feed())

    def dismiss(self, viewer: _Viewer) -> None:
        """Forgets a viewer that has gone."""
        self._viewers.discard(viewer)
        if (feed := self._feeds.pop(viewer, None)) is not None:
            feed.cancel()  # unless it has ended


class Queue:
    """Commands that wait. Of too many none is kept, and then the scene as it is says all that they would have said."""

    def __init__(self) -> None:
        self._commands: list[bytes] | None = []
        self._size = 0

    @property
    def empty(self) -> bool:
        """Whether there is nothing to do."""
        return self._commands == []

    @property
    def size(self) -> int:
        """Bytes that wait."""
        return self._size

    def put(self, command: bytes | None) -> None:
        """Adds a command; None stands for the whole scene."""
        if command is None or self._commands is None:
            self._commands, self._size = None, 0
            return
        self._commands.append(command)
        self._size += len(command)
        if len(self._commands) > MOST_COMMANDS or self._size > MOST_BYTES:
            self.put(None)

    def take(self) -> list[bytes] | None:
        """What waits, and nothing does any more; None for the whole scene."""
        commands, self._commands, self._size = self._commands, [], 0
        return commands


class _Viewer(tornado.websocket.WebSocketHandler):
    """A browser: the page at first, then the socket that the page opens at the same address."""

    def initialize(self, server: LiveServer) -> None:
        self.server, self.queue, self.awake = server, Queue(), asyncio.Event()

    async def get(self, *args: Any, **kwargs: Any) -> None:
        if self.request.headers.get("Upgrade", "").lower() == "websocket":
            await super().get(*args, **kwargs)
        else:
            self.set_header("Cache-Control", "no-store")
            self.finish(live_page(self.request.host))

    def check_origin(self, origin: str) -> bool:
        """Only a page of this server may listen: tornado's own rule, said here so that it cannot get lost."""
        return urlsplit(origin).netloc.lower() == self.request.headers.get("Host", "").lower()

    def open(self, *_: str, **__: str) -> None:
        self.server.welcome(self)

    def show(self, commands: Sequence[bytes] | None) -> None:
        """Has the page show changes, or the whole scene, as soon as it has taken what came before."""
        for command in [None] if commands is None else commands:
            self.queue.put(command)
        self.awake.set()

    async def feed(self) -> None:
        """Sends what waits, one command after the other, each when the one before has gone out."""
        told = False
        try:
            while True:
                await self.awake.wait()
                self.awake.clear()
                commands = self.queue.take()
                if commands is None:
                    commands = [*([CLEARED] if told else []), *self.server.window.commands()]
                for command in commands:
                    await self.write_message(command, binary=True)
                    told = True
        except (tornado.websocket.WebSocketClosedError, tornado.iostream.StreamClosedError):
            self.server.dismiss(self)  # it has gone

    def on_message(self, message: str | bytes) -> None:
        """A viewer has nothing to say."""

    def on_close(self) -> None:
        self.server.dismiss(self)


def _say_nothing(handler: tornado.web.RequestHandler) -> None:
    """The program's output is the program's; who asked for which page does not belong there."""
