"""Chooses the tip of a robot if the user gives none: the end of its one arm.

The search goes down the tree, always into the branch with the most joints. If several branches have the same number,
they are either the fingers of a hand, and the tip is the last link that they share; or they are the arms and legs of a
robot with several, and then only the user can choose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from robust_ik.description.joint_tree import Description, Joint
from robust_ik.errors import TipError, listed

LEAST_ARM = 3
"""Least number of joints in the arm of a hand."""
LONGEST_HAND = 0.5
"""Largest length of a finger, as a fraction of the arm's; a longer one counts as an arm."""


@dataclass(frozen=True)
class Tip:
    """A tip that was chosen.

    Attributes:
        name: The link.
        note: Why it was chosen and what else is possible; empty if the choice was clear.
    """

    name: str
    note: str = ""


def choose_tip(description: Description) -> Tip:
    """The end of the one arm: the leaf of the longest chain, or the link that its fingers share.

    Of several leaves that move alike, the tip is the one called tool0 (ROS-Industrial's name), else the last link that
    they share.

    Raises:
        TipError: Nothing moves, or several arms are equally long; the message lists their ends.
    """
    tree = _Tree(description)
    if tree.deepest[description.root] == 0:
        raise TipError(f"{description.name} has no joint that moves")
    ends = tree.ends(description.root)
    if len(ends) == 1:
        return ends[0]
    names = sorted(end.name for end in ends)
    rest = sorted(set(description.leaves) - set(names))
    shared = tree.shared(names)
    raise TipError(
        f"{description.name} has {len(ends)} chains of {tree.deepest[description.root]} joints; "
        f"give a tip (tip=, --tip), one of: {listed(names)}"
        + (f"; or {shared}, the last link that they share" if tree.sources[shared] else "")
        + (f"; or another leaf: {listed(rest, 20)}" if rest else "")
    )


class _Tree:
    """The tree of links: how many independent joints move each link, and how many more are below it."""

    def __init__(self, description: Description) -> None:
        self.description = description
        self.sources: dict[str, frozenset[str]] = {description.root: frozenset()}
        # A planar or floating joint counts as one, that of its last part: as many as a wrist has make no arm.
        last = {joint.part_of: joint.name for joint in description.joints}
        for joint in self._downwards():
            still = joint.kind == "fixed" or (joint.part_of and joint.name != last[joint.part_of])
            own = frozenset() if still else {description.driver[joint.name].source}
            above = self.sources[joint.parent]
            self.sources[joint.child] = above if own <= above else above | own

    @cached_property
    def _below(self) -> dict[str, list[Joint]]:
        below: dict[str, list[Joint]] = {link: [] for link in self.description.links}
        for joint in self.description.joints:
            below[joint.parent].append(joint)
        return below

    def _downwards(self) -> Iterator[Joint]:
        waiting = list(self._below[self.description.root])
        for joint in waiting:
            waiting += self._below[joint.child]
        return iter(waiting)

    @cached_property
    def deepest(self) -> dict[str, int]:
        """For each link, the largest number of joints that move any link below it."""
        deepest = {link: len(sources) for link, sources in self.sources.items()}
        for joint in reversed(list(self._downwards())):
            deepest[joint.parent] = max(deepest[joint.parent], deepest[joint.child])
        return deepest

    @cached_property
    def _longest(self) -> dict[str, float]:
        """For each link, the longest path to a leaf, m."""
        longest = dict.fromkeys(self.sources, 0.0)
        for joint in reversed(list(self._downwards())):
            longest[joint.parent] = max(longest[joint.parent], joint.length + longest[joint.child])
        return longest

    def ends(self, link: str) -> list[Tip]:
        """The ends of the arms that begin at a link: one, or several if they are equally long."""
        while True:
            branches = self._branches(link)
            if not branches:
                return self._ends_of_body(link)
            if self._is_hand(branches):
                return [self._hand(branches)]
            most = self.deepest[branches[0].child]
            alike = [branch for branch in branches if self.deepest[branch.child] == most]
            if len(alike) > 1:
                return [end for branch in alike for end in self.ends(branch.child)]
            link = alike[0].child

    def _branches(self, link: str) -> list[Joint]:
        """The joints that move relative to the rigid body of a link, those with the most joints below first."""
        parts = self._body(link)
        body = set(parts)
        branches = [joint for part in parts for joint in self._below[part] if joint.child not in body]
        return sorted(branches, key=lambda joint: -self.deepest[joint.child])

    def _is_hand(self, branches: list[Joint]) -> bool:
        """Whether branches are fingers: of similar numbers of joints, fewer than the arm's, and short."""
        arm = len(self.sources[branches[0].parent])
        depths = [self.deepest[branch.child] - arm for branch in branches]
        alike = depths[:2] == [depths[0]] * 2 or (len(depths) > 2 and 2 * depths[2] >= depths[0])
        if not alike or arm < LEAST_ARM or arm <= depths[0]:
            return False
        reach = self._length(self._shared_by(branches))
        fingers = (branch.length + self._longest[branch.child] for branch in branches[:2])
        return max(fingers) <= LONGEST_HAND * reach

    def _shared_by(self, branches: list[Joint]) -> str:
        alike = [each for each in branches if 2 * self._depth(each) >= self._depth(branches[0])]
        return self.shared([branch.parent for branch in alike])

    def _depth(self, branch: Joint) -> int:
        return self.deepest[branch.child] - len(self.sources[branch.parent])

    def _hand(self, branches: list[Joint]) -> Tip:
        name = self._shared_by(branches)
        leaves = sorted(leaf for leaf in self.description.leaves if name in self._above(leaf))
        return Tip(
            name,
            f"no tip was given: {name!r}, the last link that the fingers share, is what most people mean and is taken; "
            f"beyond it there are {listed(leaves, 8)} (tip=, --tip)",
        )

    def _ends_of_body(self, link: str) -> list[Tip]:
        """The leaves that no further joint moves; of one rigid body, one leaf or the link that they share."""
        leaves = [part for part in self._body(link) if not self._below[part]]
        if len(leaves) == 1 or self._moves_within(leaves, link):
            return [Tip(leaf) for leaf in leaves]
        if "tool0" in leaves:
            return [Tip("tool0")]
        name = self.shared(leaves)
        apart = [leaf for leaf in leaves if self._length(leaf) > self._length(name)]
        if len(apart) == 1:
            others = listed(sorted(set(leaves) - set(apart)), 8)
            return [
                Tip(
                    apart[0],
                    f"no tip was given: {apart[0]!r} is taken, as {others}, fixed to the same body, is where {name!r} "
                    "is (tip=, --tip)",
                )
            ]
        return [
            Tip(
                name,
                f"no tip was given: {name!r} is taken, the last link that {listed(sorted(leaves), 8)} share, which "
                "are all fixed to it (tip=, --tip)",
            )
        ]

    def _length(self, link: str) -> float:
        """The length of the path from the root to a link, m."""
        return sum(joint.length for joint in self.description.chain(link))

    def _moves_within(self, leaves: list[str], link: str) -> bool:
        """Whether mimic joints move some of the leaves relative to others."""
        above = len(self._above(link))
        chains = [self.description.chain(leaf)[above - 1 :] for leaf in leaves]
        return any(joint.kind != "fixed" for chain in chains for joint in chain)

    def _body(self, link: str) -> list[str]:
        """A link and the links below it that move with it as one rigid body."""
        body = [link]
        for part in body:
            body += [joint.child for joint in self._below[part] if self.sources[joint.child] == self.sources[link]]
        return body

    def _above(self, link: str) -> list[str]:
        """The links from the root to a link, including both."""
        return [self.description.root, *(joint.child for joint in self.description.chain(link))]

    def shared(self, links: list[str]) -> str:
        """The last link on the paths from the root to all these links."""
        ways = [self._above(link) for link in links]
        common = [step[0] for step in zip(*ways) if len(set(step)) == 1]
        return str(common[-1])
