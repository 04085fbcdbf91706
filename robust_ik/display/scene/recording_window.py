"""A window for meshcat.Visualizer that records the scene, without a server."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from robust_ik.display.scene.meshcat_module import SceneTree, find_node, umsgpack, walk
from robust_ik.errors import InputError


class RecordingWindow:
    """Accepts a Visualizer's commands and records the scene that results from them.

    It replaces meshcat's own window, which starts a server process and talks to it through sockets. Commands may come
    from several threads.
    """

    def __init__(self) -> None:
        self._tree = SceneTree()
        self._lock = threading.RLock()
        self._listeners: list[Callable[[bytes], None]] = []

    def send(self, command: Any) -> None:
        """Records a meshcat command and passes it on to listeners."""
        lowered = command.lower()
        if lowered["type"] not in _RECORD:
            raise InputError(f"the scene takes {', '.join(_RECORD)}, got {lowered['type']!r}")
        packed = umsgpack.packb(lowered)
        path = [part for part in lowered["path"].split("/") if part]
        with self._lock:
            if lowered["type"] == "delete" and not path:
                self._tree = SceneTree()
            else:
                _RECORD[lowered["type"]](self._tree, path, lowered, packed)
            for listener in self._listeners:
                listener(packed)

    def commands(self) -> list[bytes]:
        """The packed commands that build the scene again, in a working order."""
        with self._lock:
            return [command for node in walk(self._tree) for command in _commands_of(node)]

    @property
    def animated(self) -> bool:
        """Whether an animation was sent."""
        return self._tree.animation is not None

    def listen(self, listener: Callable[[bytes], None]) -> None:
        """Calls `listener` with every command from now on."""
        with self._lock:
            self._listeners.append(listener)

    def forget(self, listener: Callable[[bytes], None]) -> None:
        """Stops calling a listener."""
        with self._lock:
            self._listeners.remove(listener)


def _commands_of(node: Any) -> list[bytes]:
    parts = [node.object, *node.properties, node.transform, node.animation]
    return [part for part in parts if part is not None]


def _set_object(tree: Any, path: list[str], _: dict[str, Any], packed: bytes) -> None:
    node = find_node(tree, path)
    node.object, node.properties = packed, []


def _set_transform(tree: Any, path: list[str], _: dict[str, Any], packed: bytes) -> None:
    find_node(tree, path).transform = packed


def _set_property(tree: Any, path: list[str], lowered: dict[str, Any], packed: bytes) -> None:
    """Replaces an earlier value: a property set in a loop must not make the scene grow."""
    node = find_node(tree, path)
    others = [old for old in node.properties if umsgpack.unpackb(old)["property"] != lowered["property"]]
    node.properties = [*others, packed]


def _set_animation(tree: Any, path: list[str], _: dict[str, Any], packed: bytes) -> None:
    find_node(tree, path).animation = packed


def _delete(tree: Any, path: list[str], *_: Any) -> None:
    find_node(tree, path[:-1]).pop(path[-1], None)


_RECORD: dict[str, Callable[..., None]] = {
    "set_object": _set_object,
    "set_transform": _set_transform,
    "set_property": _set_property,
    "set_animation": _set_animation,
    "delete": _delete,
}
