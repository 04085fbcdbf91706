"""Animations in the viewer's format: for each node, curves of position, rotation, size and visibility."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.display.scene.meshcat_module import Visualizer, commands, umsgpack
from robust_ik.display.scene.primitives import packed_array
from robust_ik.display.scene.smooth_motion import quaternions

SMALLEST_SIZE = 1e-4
"""Least size: three.js needs the inverse of a size for lighting."""

LARGEST = 1e9
"""Largest coordinate of a run that diverges; larger ones would not fit the viewer's numbers."""


class Tracks:
    """Curves over common times, as arrays; meshcat's own Animation keeps every number as an object.

    Attributes:
        times: Seconds from the start, (N,).
    """

    def __init__(self, times: Array) -> None:
        self.times = np.asarray(times, dtype=np.float32)
        self._nodes: dict[str, list[dict[str, Any]]] = {}

    @classmethod
    def none(cls) -> Tracks:
        """An empty animation, which ends the one that is playing."""
        return cls(np.zeros(1))

    def pose(self, node: Visualizer, T: Array) -> None:
        """Lets a node follow poses (N, 4, 4)."""
        self.position(node, T[:, :3, 3])
        self.turn(node, T[:, :3, :3])

    def position(self, node: Visualizer, points: Array) -> None:
        """Lets a node follow points (N, 3)."""
        self._add(node, "position", "vector3", points)

    def turn(self, node: Visualizer, R: Array) -> None:
        """Lets a node follow rotations (N, 3, 3)."""
        self._add(node, "quaternion", "quaternion", quaternions(R))

    def size(self, node: Visualizer, factors: Array) -> None:
        """Scales a node by factors, (N,) or (N, 3)."""
        factors = np.asarray(factors, dtype=float)
        along = np.broadcast_to(factors[:, None], (len(factors), 3)) if factors.ndim == 1 else factors
        self._add(node, "scale", "vector3", np.maximum(along, SMALLEST_SIZE))

    def visible(self, node: Visualizer, shown: NDArray[np.bool_]) -> None:
        """Shows or hides a node over time, (N,)."""
        self._nodes.setdefault(node.path.lower(), []).append(
            {"name": ".visible", "type": "boolean", "times": packed_array(self.times), "values": shown.tolist()}
        )

    def _add(self, node: Visualizer, name: str, kind: str, values: Array) -> None:
        values = np.clip(values, -LARGEST, LARGEST).astype(np.float32)
        times = self.times
        if (values == values[0]).all():
            values, times = values[:1], times[:1]
        track = {"name": f".{name}", "type": kind, "times": packed_array(times), "values": packed_array(values)}
        self._nodes.setdefault(node.path.lower(), []).append(track)

    def lower(self) -> list[dict[str, Any]]:
        """The description for the viewer; all clips have the same duration, so that they loop together."""
        duration = float(self.times[-1])
        return [
            {"path": path, "clip": {"fps": 1, "name": "run", "duration": duration, "tracks": tracks}}
            for path, tracks in self._nodes.items()
        ]

    def command(self) -> Any:
        """The meshcat command that plays it repeatedly."""
        return commands.SetAnimation(self, play=True, repetitions=float("inf"))

    def packed(self) -> bytes:
        """`command`, packed for the viewer."""
        return bytes(umsgpack.packb(self.command().lower()))


class Still:
    """The first frame of a sequence, without motion: same methods as `Tracks`, and `place` to move the nodes."""

    def __init__(self) -> None:
        self._transforms: dict[str, tuple[Visualizer, Array]] = {}

    def position(self, node: Visualizer, points: Array) -> None:
        """Puts a node at the first of points (N, 3)."""
        self._of(node)[:3, 3] = points[0]

    def turn(self, node: Visualizer, R: Array) -> None:
        """Turns a node by the first of rotations (N, 3, 3); must be called before `size`."""
        self._of(node)[:3, :3] = R[0]

    def size(self, node: Visualizer, factors: Array) -> None:
        """Scales a node by the first of factors, (N,) or (N, 3)."""
        self._of(node)[:3, :3] *= np.maximum(factors[0], SMALLEST_SIZE)

    def visible(self, node: Visualizer, shown: NDArray[np.bool_]) -> None:
        """Shows or hides a node by the first of (N,)."""
        node.set_property("visible", bool(shown[0]))

    def place(self) -> None:
        """Sends the transforms to the scene."""
        for node, transform in self._transforms.values():
            node.set_transform(transform)

    def _of(self, node: Visualizer) -> Array:
        return self._transforms.setdefault(node.path.lower(), (node, np.eye(4)))[1]
