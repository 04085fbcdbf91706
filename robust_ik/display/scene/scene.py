"""A MeshCat scene, to save in a file or to watch while it changes."""

from __future__ import annotations

import html
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from robust_ik.checks import Array, as_measures, checked_parameter
from robust_ik.checks.public_arguments import checked
from robust_ik.display.scene.animation_tracks import Tracks
from robust_ik.display.scene.camera import View
from robust_ik.display.scene.html_page import scene_page
from robust_ik.display.scene.live_server import LiveServer
from robust_ik.display.scene.meshcat_module import Visualizer
from robust_ik.display.scene.primitives import grid, line_segments
from robust_ik.display.scene.recording_window import RecordingWindow
from robust_ik.errors import InputError
from robust_ik.runtime.output_files import write_file


class Scene:
    """A MeshCat scene. Without a server it is only recorded, for `save`; with one it can be watched in a browser.

    `scene["any/path"]` is a meshcat Visualizer, which accepts everything that meshcat can draw.

    Attributes:
        visualizer: The root node.
        server: The live server, if there is one.
    """

    @checked
    def __init__(self, server: LiveServer | None = None) -> None:
        self.server = server
        self._window = RecordingWindow() if server is None else server.window
        self.visualizer = Visualizer(window=self._window)

    @classmethod
    @checked
    def live(cls, port: int = 0) -> Self:
        """A scene that can be watched at `url`; see `serve`."""
        return cls(LiveServer(RecordingWindow(), port))

    @checked
    def __getitem__(self, path: str) -> Visualizer:
        return self.visualizer[path]

    @property
    def url(self) -> str | None:
        """The address to watch it; None if it is not served."""
        return None if self.server is None else self.server.url

    @property
    def commands(self) -> list[bytes]:
        """The packed meshcat commands that build it again."""
        return self._window.commands()

    def clear(self) -> None:
        """Removes all drawings and ends the animation."""
        self.visualizer.delete()
        if self._window.animated:
            self._window.send(Tracks.none().command())

    @checked
    def add_floor(self, size: float, height: float = 0.0) -> None:
        """Adds a light grid of about that half-size, m, instead of meshcat's."""
        size, height = checked_parameter("size", size), checked_parameter("height", height)
        step = _round(max(size, 1e-6) / 6)
        self.visualizer["/Grid"].set_property("visible", False)
        self.visualizer["/Axes"].set_property("visible", False)
        floor = self.visualizer["floor"]
        floor.set_object(line_segments(grid(size, step), 0x8A929B, opacity=0.35))
        # Slightly below, so that it does not flicker through a base that stands on it.
        floor.set_transform(_shift([0.0, 0.0, height - 2e-3 * size]))

    @checked
    def look_at(self, points: Array, along: Array | None = None, front: Array | None = None) -> None:
        """Places the camera so that points (N, 3) are in view; `along` and `front` as for `View.of`."""
        places = as_measures(points, "points", (None, 3))
        axes = [None if each is None else as_measures(each, "along and front", (3,)) for each in (along, front)]
        if places.ndim != 2 or len(places) == 0:
            raise InputError(f"points must be at least one, (N, 3), got shape {places.shape}")
        View.of(places, *axes).set_on(self.visualizer)

    @checked
    def html(self, title: str = "Scene") -> str:
        """A self-contained page of the present scene."""
        return scene_page(self.commands, title)

    @checked
    def save(self, path: str | Path, title: str = "Scene") -> Path:
        """Writes `html` to a file.

        Raises:
            InputError: The path is a folder.
        """
        return write_file(path, self.html(title))

    def close(self) -> None:
        """Stops serving; the scene can still be saved."""
        if self.server is not None:
            self.server.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """A frame for a notebook: the live page, or the present scene."""
        served = self.server is not None and self.server.running
        source = f'src="{self.url}"' if served else f'srcdoc="{html.escape(self.html())}"'
        return f'<iframe {source} style="width: 100%; height: 480px; border: 0"></iframe>'


@checked
def serve(port: int = 0) -> Scene:
    """An empty scene that a browser on this machine can watch at `scene.url`.

    The server listens on 127.0.0.1 only. It is a thread of this program and ends with it in any case.

    Args:
        port: TCP port; 0 for any free one.

    Raises:
        OSError: The port is in use.
    """
    return Scene.live(port)


def _round(length: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(min((1, 2, 5, 10), key=lambda step: abs(step - length / power)) * power)


def _shift(by: Any) -> Array:
    T = np.eye(4)
    T[:3, 3] = by
    return T
