"""Which links of a work's URDF are kept apart, and by how much: read from the file beside it. Needs NumPy only."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True)
class KeptApart:
    """Pairs that are kept apart.

    Attributes:
        pairs: Two links each; an obstacle is a fixed link.
        obstacles: Names of those that are obstacles.
        distance: The least distance, m.
        influence: The distance below which pairs act, m.
        gain: Largest rate at which the distance left may be used up, 1/s.
    """

    pairs: tuple[tuple[str, str], ...]
    obstacles: tuple[str, ...]
    distance: float
    influence: float
    gain: float

    def save(self, urdf: str) -> None:
        """Writes them beside a URDF."""
        Path(urdf).with_suffix(".pairs.json").write_text(json.dumps(asdict(self)), encoding="utf-8")

    @classmethod
    def read(cls, urdf: str) -> KeptApart:
        """What `save` wrote."""
        told = json.loads(Path(urdf).with_suffix(".pairs.json").read_text(encoding="utf-8"))
        pairs = tuple((first, second) for first, second in told.pop("pairs"))
        return cls(pairs=pairs, obstacles=tuple(told.pop("obstacles")), **told)
