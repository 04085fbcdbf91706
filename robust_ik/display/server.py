"""Shows a scene to browsers on this machine while it changes, and to nobody else."""

from __future__ import annotations

import asyncio
import socket
import threading
from typing import Any
from urllib.parse import urlsplit

import tornado.httpserver
import tornado.web
import tornado.websocket

from robust_ik.display._meshcat import VIEWER_FOLDER
from robust_ik.display.page import live_page
from robust_ik.display.window import RecordingWindow

HOST = "127.0.0.1"
# A page of another site could otherwise reach the server under a name of its own that it lets resolve to 127.0.0.1.
HOSTS = r"(127\.0\.0\.1|localhost)"


class LiveServer:
    """Serves a window's scene from a thread of this program.

    meshcat's own server is another process, which outlives a program that is killed, and its page is offered on every
    network interface.

    Attributes:
        window: Where the scene is recorded.
        address: What it listens on, (host, port).
    """

    def __init__(self, window: RecordingWindow, port: int = 0) -> None:
        self.window = window
        self._viewers: set[_Viewer] = set()
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
        """Passes a command to every viewer; called from the program's threads."""
        self._loop.call_soon_threadsafe(self._send, command)

    def _send(self, command: bytes) -> None:
        for viewer in list(self._viewers):
            viewer.show(command)

    def welcome(self, viewer: _Viewer) -> None:
        """Sends the whole scene to a viewer that has just connected, and from now on every change."""
        self._viewers.add(viewer)
        for command in self.window.commands():
            viewer.show(command)

    def dismiss(self, viewer: _Viewer) -> None:
        """Forgets a viewer that has gone."""
        self._viewers.discard(viewer)


class _Viewer(tornado.websocket.WebSocketHandler):
    """A browser: the page at first, then the socket that the page opens at the same address."""

    def initialize(self, server: LiveServer) -> None:
        self.server = server

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

    def show(self, command: bytes) -> None:
        try:
            self.write_message(command, binary=True)
        except tornado.websocket.WebSocketClosedError:
            self.server.dismiss(self)

    def on_message(self, message: str | bytes) -> None:
        """A viewer has nothing to say."""

    def on_close(self) -> None:
        self.server.dismiss(self)


def _say_nothing(handler: tornado.web.RequestHandler) -> None:
    """The program's output is the program's; who asked for which page does not belong there."""
