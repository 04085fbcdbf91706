"""What an arm can never do because of how it is built, wherever it is, in words: no singular configuration adds it."""

from __future__ import annotations

import numpy as np

from robust_ik.kinematics.svd import whole_svd
from robust_ik.singularities.geometry.screw_chain import ScrewChain

SAMPLES = 8
"""Configurations at which it is looked which joints take part. Chosen: one joint rests at all eight by no chance."""
RESTS = 1e-3
"""Share of a joint in a unit motion of all joints below which it takes no part: what rounding leaves is less."""
COUNTS = {1: "one", 2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}


def built_in(name: str, chain: ScrewChain) -> str:
    """What an arm can never do, and so what its corank counts; empty if it can move in all its rows somewhere.

    Args:
        name: Name of the robot.
        chain: What moves its tip.
    """
    rank, n, m = chain.full_rank, chain.n, chain.m
    if rank == m:
        return ""
    rows = "" if m == len(COUNTS) else f"in the rows {' '.join(chain.rows)} "
    if rank == n:
        what = f"the rows {' '.join(chain.rows)}" if rows else "six rows"
        return (
            f"{name} has {_joints(n)} for {what}: its corank is {n} − rank, how many motions of the joints do not move "
            "the tip"
        )
    if rank == 0:
        return f"{name} never moves its tip {rows}at all: there is nothing to lose"
    idle = n - rank
    motions = "one motion" if idle == 1 else f"{idle} independent motions"
    return (
        f"{name} is built so that its {_joints(n)} never move the tip {rows}in more than {COUNTS[rank]} of "
        f"{COUNTS[m]} ways: {motions}{_among(chain)} never {'moves' if idle == 1 else 'move'} it; its corank is "
        f"{rank} − rank, what is lost besides"
    )


def _joints(count: int) -> str:
    return f"{count} {'joint' if count == 1 else 'joints'}"


def _among(chain: ScrewChain) -> str:
    """The joints that take part in the motions that never move the tip, unless all do."""
    even = chain.measured_in(np.where(chain.slides, chain.length_scale, 1.0))
    motions = whole_svd(even.jacobian(even.random(np.random.default_rng(0), SAMPLES))).Vt[:, chain.full_rank :]
    taking = (np.sqrt(np.sum(motions**2, axis=1)) > RESTS).any(axis=0)
    names = [name for name, part in zip(chain.joint_names, taking) if part]
    return "" if taking.all() else f" of {', '.join(names[:-1])}{' and ' if len(names) > 1 else ''}{names[-1]}"
