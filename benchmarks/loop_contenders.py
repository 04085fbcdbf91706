"""Who runs in closed loop, and what they answered: measured, or kept from an interrupted command."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import robust_ik as rik
from benchmarks import environments
from benchmarks.environments import Peer, UnavailableError
from benchmarks.peers.loops import Loop
from benchmarks.peers.ours import METHODS


@dataclass(frozen=True)
class Contender:
    """A row of the tables.

    Attributes:
        name: What the row says.
        script: File in benchmarks/peers, without `_loop.py`; also the environment and its requirements.
        options: Of the script.
    """

    name: str
    script: str
    options: tuple[str, ...] = ()


OURS = tuple(Contender(f"robust_ik, `{name}`", "robust_ik", ("--method", name)) for name in METHODS)
PEERS = (
    Contender("Pink", "pink"),
    Contender("Pink, `lm_damping=1`", "pink", ("--lm_damping", "1")),
    Contender("Pink, `damping=1e-3`", "pink", ("--damping", "1e-3")),
    Contender("mink", "mink"),
    Contender("mink, `lm_damping=1`", "mink", ("--lm_damping", "1")),
    Contender("mink, `damping=1e-3`", "mink", ("--damping", "1e-3")),
    Contender("PlaCo", "placo"),
    Contender("PlaCo, regularised by 1e-4", "placo", ("--regularisation", "1e-4")),
    Contender("PlaCo, regularised by 1e-3", "placo", ("--regularisation", "1e-3")),
)


def default_method() -> str | None:
    """Which of METHODS a controller takes that is told nothing."""
    resolver = rik.VelocityController(rik.load("planar_2r")).resolver
    return next((name for name, method in METHODS.items() if method.resolver == resolver), None)


@dataclass(frozen=True)
class Answer:
    """What a contender made of some runs.

    Attributes:
        version: Of its package.
        runs: As `peers.loops.driven` gives them.
        failure: Why there are none.
    """

    version: str = ""
    runs: list[dict[str, Any]] = field(default_factory=list)
    failure: str = ""


def answer(contender: Contender, loop: Loop, label: str) -> Answer:
    """Measures a contender, or takes what is kept. Who fails is asked again by the next command.

    Args:
        contender: Who.
        loop: Runs.
        label: What they are called in the name of the kept file.
    """
    folder = environments.CACHE.parent / "closed_loop"
    folder.mkdir(parents=True, exist_ok=True)
    arrays = [np.asarray(value).tobytes() for value in vars(loop).values()]
    made = _digest(*arrays, repr(told(contender)).encode(), _sources(contender.script))
    kept = folder / f"{label}-{contender.script}-{made.hex()[:16]}.json"
    if kept.is_file():
        return Answer(**json.loads(kept.read_text(encoding="utf-8")))
    runs = loop.save(kept.with_suffix(".npz"))
    try:
        with Peer(contender.script, "loop", runs, contender.options) as running:
            found = Answer(running.hello["version"], list(running.round().answers))
    except UnavailableError as error:
        return Answer(failure=str(error))
    finally:
        runs.unlink()
    half = kept.with_suffix(".part")
    half.write_text(json.dumps(vars(found)), encoding="utf-8")
    half.replace(kept)
    return found


def told(contender: Contender) -> tuple[object, ...]:
    """The options of its script; a method of ours itself and not only its name."""
    return tuple(METHODS.get(option, option) for option in contender.options)


@cache
def _sources(script: str) -> bytes:
    """A digest of all that decides how a contender runs."""
    scripts = environments.SCRIPTS
    files = [scripts / "loops.py", scripts / "looping.py", scripts / f"{script}_loop.py"]
    if script == "robust_ik":
        files += [scripts / "ours.py", *sorted(Path(rik.__file__).parent.rglob("*.py"))]
    else:
        files.append(scripts / f"requirements-{script}.txt")
    return _digest(*(path.read_bytes() for path in files if path.is_file()))


def _digest(*parts: bytes) -> bytes:
    made = hashlib.sha256()
    for part in parts:
        made.update(len(part).to_bytes(8, "big") + part)
    return made.digest()
