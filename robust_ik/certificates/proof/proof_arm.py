"""The arm that a proof is about, in rational numbers, and how it is read from JSON."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from robust_ik.certificates.proof.untrusted_json import (
    CertificateError,
    a_fraction,
    a_list,
    a_text,
    an_integer,
    an_object,
)
from robust_ik.kinematics.twist_rows import ROWS

VERSION = 3
"""The version of proofs that is written."""
TURNING_ONLY, FULL_RANK = 1, 2
"""The versions before sliding joints, in which all joints turn, and before arms that never have full rank."""
MAX_JOINTS = 20
"""Most joints of an arm. Chosen: twice as many as the longest arms that are searched for singular configurations."""
TURNS = ("1", "-1", "2", "-2")
"""How many times as far a joint may turn as the one that it follows: more are not needed, and make degrees high."""


@dataclass(frozen=True)
class Arm:
    """The rational arm that the proof is about.

    Attributes:
        name: The robot's name.
        joints: Names of the n joints.
        rows: Task rows.
        links: The c + 1 constant transforms: three rows of the rotation, then the translation, fractions as text.
        changes: How it differs from the robot it was made from, one sentence each.
        sliding: Indices of the prismatic joints, ascending; the others turn about their z.
        rank: g, the rank of its Jacobian nearly everywhere; by default the number of rows or joints, the smaller one.
        motions: For each of the c motions from the base to the tip, the index of its joint, and how many times as far
            it moves, a fraction as text, ±1 or ±2 for turns; by default each joint moves once, by its value.
    """

    name: str
    joints: tuple[str, ...]
    rows: tuple[str, ...]
    links: tuple[tuple[tuple[str, ...], ...], ...]
    changes: tuple[str, ...] = ()
    sliding: tuple[int, ...] = ()
    rank: int = 0
    motions: tuple[tuple[int, str], ...] = ()

    def __post_init__(self) -> None:
        if not self.motions:
            object.__setattr__(self, "motions", tuple((joint, "1") for joint in range(len(self.joints))))
        if self.rank == 0:
            object.__setattr__(self, "rank", min(len(self.rows), len(self.joints)))


def always_said(arm: Arm) -> dict[str, Any]:
    """What is said of every arm, also where it is what is usual."""
    return {"sliding": list(arm.sliding), "rank": arm.rank, "motions": [list(each) for each in arm.motions]}


def read_arm(data: Any, version: int) -> Arm:
    """An arm from JSON data of a version of proofs."""
    data = an_object(data, "arm", {"name", "joints", "rows", "links", "changes", "sliding", "rank", "motions"})
    if ("sliding" in data) != (version > TURNING_ONLY):
        raise CertificateError(f"an arm says which joints slide from version {FULL_RANK} on, and not before")
    if {"rank", "motions"} & set(data) != ({"rank", "motions"} if version > FULL_RANK else set()):
        why = f"an arm says what its rank is, and what follows what, from version {VERSION} on, and not before"
        raise CertificateError(why)
    joints = tuple(a_text(name, "a joint name") for name in a_list(data.get("joints"), "joints", MAX_JOINTS))
    rows = tuple(a_text(name, "a row") for name in a_list(data.get("rows"), "rows", 6))
    if not joints or not rows or len(set(rows)) < len(rows) or any(row not in ROWS for row in rows):
        raise CertificateError(f"an arm has joints, and rows of {' '.join(ROWS)}")
    links = tuple(_link(link) for link in a_list(data.get("links"), "links", MAX_JOINTS + 1))
    changes = tuple(a_text(each, "a change") for each in a_list(data.get("changes", []), "changes", 1000))
    given = a_list(data.get("sliding", []), "sliding", len(joints))
    sliding = tuple(an_integer(joint, "sliding joint", 0, len(joints) - 1) for joint in given)
    if list(sliding) != sorted(set(sliding)):
        raise CertificateError("the sliding joints are named once each, rising")
    motions = _motions(data["motions"], len(joints), sliding) if "motions" in data else ()
    count = len(motions) if motions else len(joints)
    if len(links) != count + 1:
        raise CertificateError(f"{count} motions need {count + 1} links, got {len(links)}")
    most = min(len(rows), len(joints))
    rank = an_integer(data.get("rank", most), "rank", 1, most)
    return Arm(a_text(data.get("name"), "name"), joints, rows, links, changes, sliding, rank, motions)


def _motions(data: Any, joints: int, sliding: tuple[int, ...]) -> tuple[tuple[int, str], ...]:
    """What moves from the base to the tip, in order: each joint moves something, and turns are whole multiples."""
    found = []
    for pair in a_list(data, "motions", MAX_JOINTS):
        if len(a_list(pair, "a motion", 2)) != 2:
            raise CertificateError("a motion is a joint and a factor")
        joint, factor = an_integer(pair[0], "joint of a motion", 0, joints - 1), a_fraction(pair[1])
        if factor not in TURNS if joint not in sliding else Fraction(factor) == 0:
            raise CertificateError(f"a joint that moves {factor[:40]} times as far as joint {joint}")
        found.append((joint, factor))
    if {joint for joint, _ in found} != set(range(joints)):
        raise CertificateError("a joint moves nothing")
    return tuple(found)


def _link(data: Any) -> tuple[tuple[str, ...], ...]:
    rows = tuple(tuple(a_fraction(x) for x in a_list(row, "a row of a link", 3)) for row in a_list(data, "a link", 4))
    if [len(row) for row in rows] != [3, 3, 3, 3]:
        raise CertificateError("a link is three rows of a rotation and a translation, three numbers each")
    return rows
