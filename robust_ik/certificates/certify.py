"""Makes a proof from a robot."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import signal
import subprocess
import sys
import time
from fractions import Fraction
from typing import TYPE_CHECKING

from robust_ik.certificates.effort import Effort
from robust_ik.certificates.proof.proof import Proof
from robust_ik.certificates.proof.proof_arm import Arm
from robust_ik.certificates.prover.exact_arm import ExactArm, UnsupportedError, exact_arm
from robust_ik.checks import checked_parameter
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

LINKS = 3
"""Number of links whose frames are tried, the middle one first, where entries of J are shortest. Chosen: more take
longer."""
LONGEST = 1e6
"""Upper bound of a time limit, s; a system's clocks cannot wait for much longer."""
WORTH_A_PROCESS = 2.0
"""Seconds that must be left to start a separate process."""


@checked
def certify(robot: Robot, corank: int, *, snap: float = 1e-4, time_limit: float = 60.0, thorough: bool = True) -> Proof:
    """Proves where an arm's Jacobian loses rank, by an exact case split; the `status` says if it is complete.

    Work of a few seconds is done here and bounded by a count of steps: such a proof is the same on every machine, to
    the letter. Longer work is done by a separate process, which is ended when the time is up.

    Args:
        robot: A chain of revolute, continuous and prismatic joints; its `rows` are the task. Joints may follow others
            of their kind: turns as fast or twice as fast, to or fro, slides at any rate.
        corank: The corank, 1 or more: rank ≤ g − corank, g being the rank of the arm in its rows nearly everywhere.
        snap: Angles this close to a multiple of a quarter turn are replaced by it, rad.
        time_limit: Seconds after which undecided cases stay open, up to a million.
        thorough: Whether a process may be started. Without it the proof does not depend on the speed of the machine,
            unless the work of a few seconds takes longer than the time limit.

    Raises:
        InputError: The robot's rank cannot have this corank, or the time limit is not valid.
    """
    time_limit = checked_parameter("time_limit", time_limit, least=0, below=LONGEST)
    _check_corank(robot, corank, min(len(robot.rows), robot.n))
    if importlib.util.find_spec("flint") is None:
        return Proof(None, corank, reason="python-flint is not installed")
    try:
        arm = exact_arm(robot, snap)
    except UnsupportedError as error:
        return Proof(None, corank, reason=str(error))
    _check_corank(robot, corank, arm.rank)
    return certify_exact(arm, corank, time_limit=time_limit, thorough=thorough)


def _check_corank(robot: Robot, corank: int, largest: int) -> None:
    if not isinstance(corank, int) or not 1 <= corank <= largest:
        raise InputError(f"corank must be from 1 to {largest} for {robot.name}, got {corank!r}")


def certify_exact(arm: ExactArm, corank: int, *, time_limit: float = 60.0, thorough: bool = True) -> Proof:
    """`certify` for an arm in rational numbers."""
    deadline = time.monotonic() + time_limit
    proof = best_proof(arm, corank, deadline, Effort.quick(arm.n))
    left = deadline - time.monotonic()
    if not thorough or proof.status != "open" or left < WORTH_A_PROCESS:
        return proof
    return _in_a_process(arm, corank, left) or proof


def certify_plain(arm: Arm, corank: int) -> Proof:
    """A proof for the arm of an earlier proof, by quick work alone; "unsupported" without python-flint."""
    if importlib.util.find_spec("flint") is None:
        return Proof(None, corank, reason="python-flint is not installed")
    return certify_exact(exact_from_plain(arm), corank, thorough=False)


def best_proof(arm: ExactArm, corank: int, deadline: float, effort: Effort) -> Proof:
    """The first complete proof over the links tried, else the best incomplete one."""
    from robust_ik.certificates.prover.case_split import split
    from robust_ik.certificates.prover.jacobian_columns import middle_links

    best: Proof | None = None
    for link in middle_links(arm)[:LINKS]:
        spoilt = _spoilt(best, effort)
        proof = Proof(plain_arm(arm), corank, link, split(arm, corank, link, deadline, effort, spoilt))
        if proof.status == "proved":
            return proof
        if best is None or _rank(proof) < _rank(best):
            best = proof
        if time.monotonic() > deadline or effort.steps < 0:
            break
    assert best is not None
    return best


def _spoilt(best: Proof | None, effort: Effort) -> tuple[str, ...]:
    """The kinds of cases that make a proof no better than the best one so far, or than none."""
    if best is None:
        return () if effort.whole else ("open",)
    return ("open",) if best.status == "open" else ("open", "implicit")


def plain_arm(arm: ExactArm) -> Arm:
    """The arm in the form in which a proof holds it."""
    links = tuple(
        tuple(tuple(str(a) for a in row) for row in (*rotation, offset)) for rotation, offset in arm.placements
    )
    changes = tuple(str(change) for change in arm.changes)
    motions = tuple((joint, str(factor)) for joint, factor in arm.motions)
    return Arm(arm.name, arm.joints, arm.rows, links, changes, tuple(sorted(arm.sliding)), arm.rank, motions)


def exact_from_plain(arm: Arm) -> ExactArm:
    """The inverse of `plain_arm`, except for the changes."""
    placements = tuple(
        (tuple(tuple(Fraction(a) for a in row) for row in link[:3]), tuple(Fraction(a) for a in link[3]))
        for link in arm.links
    )
    motions = tuple((joint, Fraction(factor)) for joint, factor in arm.motions)
    return ExactArm(arm.name, arm.joints, placements, arm.rows, sliding=frozenset(arm.sliding), motions=motions)


def _rank(proof: Proof) -> int:
    return ("proved", "implicit", "open").index(proof.status)


# ---------------------------------------------------------------------------------------------------- the process
def _in_a_process(arm: ExactArm, corank: int, seconds: float) -> Proof | None:
    """The proof found by a process that is ended when the time is up; None if it found none."""
    task = json.dumps({"proof": Proof(plain_arm(arm), corank).to_json(), "seconds": seconds})
    command = [sys.executable, "-c", "from robust_ik.certificates.certify import work; work()"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path) or "."}
    try:
        done = subprocess.run(
            command, input=task, capture_output=True, text=True, timeout=seconds, check=True, env=environment
        )
    except (subprocess.SubprocessError, OSError):
        return None
    return Proof.from_json(done.stdout)


def work() -> None:
    """Main function of the process: reads a task from standard input, writes the proof to standard output."""
    task = json.loads(sys.stdin.read())
    if hasattr(signal, "alarm"):  # ends it in the middle of any step, even if the parent is gone
        signal.alarm(math.ceil(task["seconds"]) + 1)
    asked = Proof.from_json(task["proof"])
    assert asked.arm is not None
    deadline = time.monotonic() + 0.9 * task["seconds"]
    sys.stdout.write(best_proof(exact_from_plain(asked.arm), asked.corank, deadline, Effort.thorough()).to_json())
