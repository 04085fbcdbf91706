"""Scores of a contender on an arm: measured, or kept from an interrupted command."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

import robust_ik as rik
from benchmarks import environments
from benchmarks.environments import Peer
from benchmarks.robustness.arms import arm, for_tuning, scenarios
from benchmarks.robustness.contenders import Contender
from robust_ik.simulation import robustness
from robust_ik.simulation.robustness import RobustnessScenario, RunKey, RunScore, RunTrace, key_of, score, scored

KEPT = environments.CACHE.parent / "robustness"
JUDGES = ("lockstep_runs.py", "benchmark_methods.py", "run_metrics.py")
METHODS = ("inverses", "control", "kinematics")
"""Files and rooms of the package on which scores of its own methods depend, beside the scenarios themselves."""


def measured(contender: Contender, name: str, *, tuning: bool = False) -> dict[RunKey, RunScore]:
    """The scores of a contender on all scenarios of an arm, or on those for tuning.

    Raises:
        UnavailableError: It is another package that cannot be run here.
    """
    chosen = for_tuning(name) if tuning else scenarios(name)
    digest = _digest(
        repr((contender.kind, contender.script, contender.parameters)).encode(),
        _sources(contender.script),
        *map(_told, chosen),
    )
    kept = KEPT / f"{name}-{contender.script or contender.kind}-{digest[:16]}.json"
    if kept.is_file():
        found = json.loads(kept.read_text(encoding="utf-8"))
        return {key_of(each): RunScore.from_json(told) for each, told in zip(chosen, found)}
    KEPT.mkdir(parents=True, exist_ok=True)
    robot = arm(name)[0]
    if contender.script:
        traces = peer_traces(contender, name, chosen)
        scores = {key_of(each): score(robot, each, trace) for each, trace in zip(chosen, traces)}
    else:
        scores = scored(robot, chosen, contender.method())
    half = kept.with_suffix(".part")
    half.write_text(json.dumps([each.to_json() for each in scores.values()]), encoding="utf-8")
    half.replace(kept)
    return scores


def peer_traces(contender: Contender, name: str, chosen: Sequence[RobustnessScenario]) -> list[RunTrace]:
    """What another package makes of scenarios: its script gets arrays and gives joint values and commands.

    Raises:
        UnavailableError: It cannot be run here.
    """
    _, chain, path = arm(name)
    digest = _digest(repr((contender.label, contender.parameters)).encode())[:8]
    work = KEPT / f"{name}-{contender.script}-{digest}-{len(chosen)}.npz"
    arrays = {
        "urdf": str(path), "tip": chain.tip, "joints": chain.joints, "placements": chain.placements,
        "tool": chain.tool, "rows": chosen[0].rows, "parameters": json.dumps(dict(contender.parameters)),
        "count": len(chosen), "pose": arm(name)[0].pose(np.array([each.start for each in chosen])),
    }  # fmt: skip
    for i, each in enumerate(chosen):
        noise = each.disturbances()
        arrays |= {
            f"{i} start": each.start, f"{i} targets": each.targets, f"{i} forward": each.feedforward,
            f"{i} of_joints": noise[0], f"{i} of_rows": noise[1], f"{i} units": each.units,
            f"{i} speed": each.speed, f"{i} acceleration": each.acceleration,
            f"{i} numbers": np.array([each.dt, each.gain, each.cap, each.drive]),
        }  # fmt: skip
    work.parent.mkdir(parents=True, exist_ok=True)
    np.savez(work, **arrays)
    try:
        with Peer(contender.script, "track", work) as running:
            answers = Path(str(running.round().answers))
        with np.load(answers) as found:
            traces = [
                RunTrace(found[f"{i} q"], found[f"{i} commanded"], int(found[f"{i} failed"]), float(found["seconds"]))
                for i in range(len(chosen))
            ]
        answers.unlink()
    finally:
        work.unlink()
    return traces


def _told(scenario: RobustnessScenario) -> bytes:
    return repr(
        [
            (name, value.tobytes() if isinstance(value, np.ndarray) else value)
            for name, value in vars(scenario).items()
            if name != "feedforward"
        ]
    ).encode()


@cache
def _sources(script: str) -> bytes:
    """All that decides how a contender runs and is judged."""
    room = Path(robustness.__file__).parent
    files = [room / name for name in JUDGES]
    if script:
        scripts = environments.SCRIPTS
        files = [
            files[-1],
            scripts / "tracking.py",
            scripts / f"{script}_track.py",
            scripts / f"requirements-{script}.txt",
        ]
    else:
        files += [path for folder in METHODS for path in sorted((Path(rik.__file__).parent / folder).rglob("*.py"))]
    return b"".join(path.read_bytes() for path in files if path.is_file())


def _digest(*parts: bytes) -> str:
    made = hashlib.sha256()
    for part in parts:
        made.update(len(part).to_bytes(8, "big") + part)
    return made.hexdigest()
