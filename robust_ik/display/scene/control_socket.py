"""The socket through which a page with the token moves what it shows, and is told what is going on."""

from __future__ import annotations

import asyncio
import hmac
from typing import TYPE_CHECKING, Protocol
from urllib.parse import urlsplit

import tornado.iostream
import tornado.websocket

if TYPE_CHECKING:
    from robust_ik.display.scene.live_server import LiveServer


class Controls(Protocol):
    """What pages may send, and what they are told, besides the scene."""

    @property
    def token(self) -> str:
        """What a page must know to move anything: new for each run."""

    def page(self, host: str) -> str:
        """The page that has the token.

        Args:
            host: The server's host and port.
        """

    def receive(self, message: str | bytes) -> None:
        """Takes a message of a page; returns at once, and raises nothing."""

    def newest(self) -> list[str]:
        """The newest of each kind of message for pages."""


def is_token(given: str, token: str) -> bool:
    """Whether a page knows the token, in a time that does not tell how much of it."""
    return hmac.compare_digest(given.encode(), token.encode())


class ControlSocket(tornado.websocket.WebSocketHandler):
    """A page that moves what it shows. One that falls behind is told the newest only, so that nothing piles up."""

    def initialize(self, server: LiveServer, controls: Controls) -> None:
        """Keeps what the server passes to each connection."""
        self.server, self.controls, self.awake = server, controls, asyncio.Event()
        self.told: dict[int, str] = {}

    def check_origin(self, origin: str) -> bool:
        """Accepts pages of this server only."""
        return urlsplit(origin).netloc.lower() == self.request.headers.get("Host", "").lower()

    def prepare(self) -> None:
        """Refuses those without the token."""
        if not is_token(self.get_argument("token", ""), self.controls.token):
            self.send_error(403)

    def open(self, *_: str, **__: str) -> None:
        """Begins to tell what is going on."""
        self.server.admit(self)
        self.awake.set()

    def on_message(self, message: str | bytes) -> None:
        """Passes a message on."""
        self.controls.receive(message)

    async def feed(self) -> None:
        """Sends what is new, each message after the one before has been sent."""
        try:
            while True:
                await self.awake.wait()
                self.awake.clear()
                for kind, message in enumerate(self.controls.newest()):
                    if self.told.get(kind) != message:
                        self.told[kind] = message
                        await self.write_message(message)
        except (tornado.websocket.WebSocketClosedError, tornado.iostream.StreamClosedError):
            self.server.release(self)  # disconnected

    def on_close(self) -> None:
        """Tells no more."""
        self.server.release(self)
