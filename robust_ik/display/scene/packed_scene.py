"""Packs scene commands for a file: each geometry once, and no identifiers that reveal the machine."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from typing import Any

from robust_ik.display.scene.meshcat_module import umsgpack


def packed_scene(commands: Iterable[bytes]) -> list[str]:
    """The commands in base64, for our pages.

    A geometry used by several objects becomes a command of its own, "share_geometry", to which they refer. meshcat's
    identifiers contain the machine's network address and the time; they are replaced by numbers, so that the same scene
    gives the same text.
    """
    return [base64.b64encode(command).decode("ascii") for command in _Packer().pack(commands)]


class _Packer:
    def __init__(self) -> None:
        self._keys: dict[bytes, int] = {}
        self._identifiers: dict[str, str] = {}

    def pack(self, commands: Iterable[bytes]) -> list[bytes]:
        packed: list[bytes] = []
        for command in commands:
            content = umsgpack.unpackb(command)
            if content["type"] == "set_object":
                packed += self._geometries(content["object"])
                command = umsgpack.packb(self._renamed(content))
            packed.append(command)
        return packed

    def _geometries(self, described: dict[str, Any]) -> list[bytes]:
        """Replaces geometries by references; returns the commands that must come first."""
        needed = []
        for index, geometry in enumerate(described.get("geometries", ())):
            body = {key: value for key, value in geometry.items() if key != "uuid"}
            content = umsgpack.packb(body)
            if content not in self._keys:
                self._keys[content] = len(self._keys)
                needed.append(umsgpack.packb({"type": "share_geometry", "key": self._keys[content], "geometry": body}))
            described["geometries"][index] = {"uuid": geometry["uuid"], "shared": self._keys[content]}
        return needed

    def _renamed(self, value: Any, key: str = "") -> Any:
        if isinstance(value, dict):
            return {name: self._renamed(entry, name) for name, entry in value.items()}
        if isinstance(value, list):
            return [self._renamed(entry) for entry in value]
        if key in ("uuid", "geometry", "material", "map", "image") and isinstance(value, str):
            return self._identifiers.setdefault(value, f"id{len(self._identifiers)}")
        return value
