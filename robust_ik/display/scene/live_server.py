"""Shows a changing scene to browsers on this machine only."""

from __future__ import annotations

import asyncio
import reprlib
import socket
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

import tornado.httpserver
import tornado.iostream
import tornado.web
import tornado.websocket

from robust_ik.display.scene.control_socket import Controls, ControlSocket, is_token
from robust_ik.display.scene.html_page import live_page
from robust_ik.display.scene.meshcat_module import VIEWER_FOLDER, umsgpack
from robust_ik.display.scene.recording_window import RecordingWindow
from robust_ik.errors import InputError

HOST = "127.0.0.1"
# A page of another site could otherwise reach the server under its own name, if it resolves that to 127.0.0.1.
HOSTS = r"(127\.0\.0\.1|localhost)"

LONGEST_MESSAGE = 16_384
"""Most bytes of a message from a page; a longer one ends its connection. Chosen: four times the longest command."""
MOST_COMMANDS, MOST_BYTES = 4_000, 8_000_000
"""Most commands and bytes that wait for a viewer: one that falls further behind gets the whole scene instead."""
CLEARED: bytes = umsgpack.packb({"type": "delete", "path": "/meshcat"})
"""The command that removes what scenes draw; the viewer's own grid and lights stay."""


class LiveServer:
    """Serves a window's scene from a thread of this program.

    meshcat's own server is a separate process, which survives a program that is killed, and offers its page on every
    network interface.

    Attributes:
        window: The window that records the scene.
        controls: What pages with its token may move; None if they only watch.
        address: Its address, (host, port).
    """

    def __init__(self, window: RecordingWindow, port: int = 0, controls: Controls | None = None) -> None:
        if isinstance(port, bool) or not isinstance(port, int) or not 0 <= port < 65536:
            raise InputError(f"port must be a whole number from 0 to 65535, got {reprlib.repr(port)}")
        self.window, self.controls = window, controls
        self._viewers: set[_Viewer] = set()
        self._pages: set[ControlSocket] = set()
        self._feeds: dict[_Viewer | ControlSocket, asyncio.Task[None]] = {}
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
        """The address of the page; with the token if there is one."""
        token = "" if self.controls is None else f"?token={self.controls.token}"
        return f"http://{HOST}:{self.address[1]}/{token}"

    @property
    def running(self) -> bool:
        """Whether it is not closed."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Disconnects all viewers and frees the port; does nothing if it is closed."""
        if not self.running:
            return
        self.window.forget(self._forward)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()

    def _run(self, listener: socket.socket) -> None:
        asyncio.set_event_loop(self._loop)
        application = tornado.web.Application(log_function=_say_nothing, websocket_max_message_size=LONGEST_MESSAGE)
        moving = [] if self.controls is None else [
            (r"/control", ControlSocket, {"server": self, "controls": self.controls})
        ]  # fmt: skip
        application.add_handlers(HOSTS, [
            (r"/", _Viewer, {"server": self}), *moving,
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
        for each in [*self._viewers, *self._pages]:
            each.close()
        await server.close_all_connections()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _forward(self, command: bytes) -> None:
        """Passes a command to all viewers; called from the program's threads, which may be faster than the server."""
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

    def tell(self) -> None:
        """Has all pages told what is new; called from the program's threads."""
        with suppress(RuntimeError):  # it is closed, and nobody is left to be told
            self._loop.call_soon_threadsafe(self._tell)

    def _tell(self) -> None:
        for page in self._pages:
            page.awake.set()

    def admit(self, page: ControlSocket) -> None:
        """Tells a page that may move things what is going on, and all that changes from now on."""
        self._pages.add(page)
        self._feeds[page] = self._loop.create_task(page.feed())

    def release(self, page: ControlSocket) -> None:
        """Removes a page that has disconnected."""
        self._pages.discard(page)
        self._end(page)

    def welcome(self, viewer: _Viewer) -> None:
        """Sends the whole scene to a new viewer, and every change from now on."""
        self._viewers.add(viewer)
        viewer.show(None)
        self._feeds[viewer] = self._loop.create_task(viewer.feed())

    def dismiss(self, viewer: _Viewer) -> None:
        """Removes a viewer that has disconnected."""
        self._viewers.discard(viewer)
        self._end(viewer)

    def _end(self, connection: _Viewer | ControlSocket) -> None:
        if (feed := self._feeds.pop(connection, None)) is not None:
            feed.cancel()  # unless it has ended


class Queue:
    """Waiting commands; if there are too many they are dropped, and the whole scene is sent instead."""

    def __init__(self) -> None:
        self._commands: list[bytes] | None = []
        self._size = 0

    @property
    def empty(self) -> bool:
        """Whether nothing is waiting."""
        return self._commands == []

    @property
    def size(self) -> int:
        """Number of waiting bytes."""
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
        """Returns the waiting commands and empties the queue; None stands for the whole scene."""
        commands, self._commands, self._size = self._commands, [], 0
        return commands


class _Viewer(tornado.websocket.WebSocketHandler):
    """A connected browser: first the page, then the socket that the page opens at the same address."""

    def initialize(self, server: LiveServer) -> None:
        self.server, self.queue, self.awake = server, Queue(), asyncio.Event()

    async def get(self, *args: Any, **kwargs: Any) -> None:
        if self.request.headers.get("Upgrade", "").lower() == "websocket":
            await super().get(*args, **kwargs)
        else:
            self.set_header("Cache-Control", "no-store")
            self.finish(self._page())

    def _page(self) -> str:
        """The page that moves things for those who know the token; for others the one that shows them."""
        controls, host = self.server.controls, self.request.host
        if controls is not None and is_token(self.get_argument("token", ""), controls.token):
            return controls.page(host)
        return live_page(host)

    def check_origin(self, origin: str) -> bool:
        """Accepts pages of this server only: tornado's own rule, repeated here so that it cannot get lost."""
        return urlsplit(origin).netloc.lower() == self.request.headers.get("Host", "").lower()

    def open(self, *_: str, **__: str) -> None:
        self.server.welcome(self)

    def show(self, commands: Sequence[bytes] | None) -> None:
        """Sends changes, or the whole scene, as soon as earlier commands have been sent."""
        for command in [None] if commands is None else commands:
            self.queue.put(command)
        self.awake.set()

    async def feed(self) -> None:
        """Sends the waiting commands, each after the one before has been sent."""
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
            self.server.dismiss(self)  # disconnected

    def on_message(self, message: str | bytes) -> None:
        """Ignores messages from viewers."""

    def on_close(self) -> None:
        self.server.dismiss(self)


def _say_nothing(handler: tornado.web.RequestHandler) -> None:
    """The program's output is the program's; who asked for which page does not belong there."""
