"""URDF files as exporters and people get them wrong, held against what Pinocchio's own reader makes of them.

What Pinocchio reads is read, with the same kinematics of the chain, or refused for a reason of a list; whatever it
refuses is read or refused, in one sentence. Nothing else may come up.
"""

from __future__ import annotations

import contextlib
import logging
import os
import random
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

import robust_ik as rik
from robust_ik.description.catalog import EXAMPLES, catalog
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf.urdf_reader import parse_urdf, read_urdf

LARGEST_BASE = 25_000
"""Bytes of the files that are mutated: larger ones take time and hold nothing else."""
APART = 1_000_003
"""Between the numbers of files of one seed and the next."""
DATA = Path(__file__).parents[1] / "data"

STATED = (
    r"DOCTYPE",
    r"Entity '.*' not defined",
    r"Extra content at the end of the document",
    r"has a zero axis",
    r"limits reversed",
    r"negative speed limit",
    r"mimics itself",
    r"finite numbers? of at most 1e\+(06|18)",
    r"mimics joint '.*', of which .* can be mimicked",
    r"no joint (that )?moves",
    r"xacro that was not expanded",
    r"a <(link|joint)> in line \d+ has no name",
    r"has a <mimic> that names no joint",
    r"the joints form a loop",
    r"is the child of two joints",
    r"must be written <(link|joint)>",
    r"mesh path .* (climbs out|names no package)",
)
"""Why a file that Pinocchio reads may be refused."""

NUMBERS = (
    "", " ", "0", "-0", "1.0f", "1e", "nan", "inf", "-inf", "1e400", "+1", ".5", "5.", "0x1", "1_0", "0,5", "1m",
    "90deg", "pi", "−1", "１", "1 ", " 1", "1e3", "1e9", "1e-400", "--1", "1-1", "1.2.3", "${x}", "one",
)  # fmt: skip
NAMES = ("", " ", "a b", "é", "臂", "a&b", "<", "'", "a:b", "a/b", "x" * 300, "world", "0")
JUNK = (
    "<drake:acceleration value='1'/>", "<gazebo reference='x'><sensor:camera n='1'/><mu1>a, b</mu1></gazebo>",
    "<xacro:property name='w' value='1'/>", "<transmission name='t'><joint name='j'/><axis xyz='a'/></transmission>",
    "<!-- a -- b -->", "<!-- --->", "<ros2_control><link/><joint/><limit lower='?'/></ros2_control>", "text",
    "<a b='1 < 2'/>", "<a b='x & y'>z & z</a>", "<a b='1'c='2'/>", "<a>&nbsp;</a>", "<![CDATA[ <joint> ]]>", "\x01",
    "<material name='m'><color rgba='1 0 0'/></material>", "<material name='m'/>", "<a:b:c/>", "<link/>", "<joint/>",
    "<sensor name='s'><origin xyz='nan'/></sensor>", "<frame link='a' name='f'/>", "<?php x ?>", "&#1;", "<A/>", "é",
    "]]>", "\x0b",
)  # fmt: skip
HEADS = (
    "", "<?xml version='1.0'?>", "\n<?xml version='1.0'?>", "<?xml version='0.0'?>", "<?xml version='1.1'?>", "\ufeff",
    "<!-- c -->\n<?xml version='1.0'?>", "<?xml version='1.0' encoding='latin-1'?>", "<?xml?>", "<!DOCTYPE robot>",
    "  ",
    "<?xml version='1.0' encoding='utf-8' standalone='no' ?>", "<?xml version='1.0' encoding='klingon'?>",
)  # fmt: skip
TAILS = ("", "\n\n", "\0", "text", "<a/>", "<!-- -- -->", ">", "</robot>", "\x1a")
ENCODINGS = ("utf-8", "utf-8-sig", "latin-1", "cp1252", "utf-16")
SHAPES = (
    "<box size='1 2'/>", "<sphere radius='-1'/>", "<cylinder radius='1'/>", "<mesh filename='a.stl' scale='1 1 1 1'/>",
    "<capsule radius='1' length='1'/>", "", "<mesh/>", "<box size='1,2,3'/>", "<sphere radius='nan'/>",
)  # fmt: skip

_TAG = re.compile(r"<(\w+)((?:\s+[\w:]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*)\s*/?>")
_ATTRIBUTE = re.compile(r"\s+([\w:]+)\s*=\s*(\"[^\"]*\"|'[^']*')")
Mistake = Callable[[str, random.Random], str]


@cache
def bases() -> tuple[tuple[str, str], ...]:
    """Texts of small robots, and the tip of each."""
    paths = [entry.path for entry in catalog().values() if entry.source == EXAMPLES]
    paths = [path for path in paths if path.stat().st_size < LARGEST_BASE] + sorted(DATA.glob("*.urdf"))
    return tuple(_base(path) for path in paths if path.stem != "xacro_unexpanded" and _tip(path))


def _base(path: Path) -> tuple[str, str]:
    return path.read_bytes().decode("utf-8", "replace"), _tip(path)


@cache
def _tip(path: Path) -> str:
    try:
        return choose_tip(read_urdf(path)).name
    except rik.TipError as error:
        found = re.search(r"one of: ([^,;]+)", str(error))
        return "" if found is None else found[1]


# -------------------------------------------------------------------------------------------------- the mistakes
def _somewhere(text: str, chance: random.Random, what: str) -> str:
    """Puts something after a tag."""
    tags = list(_TAG.finditer(text))
    if not tags:
        return text + what
    place = chance.choice(tags).end()
    return text[:place] + what + text[place:]


def _attribute(text: str, chance: random.Random, change: Callable[[str, str], str], only: str = "") -> str:
    """Changes one attribute: name and quoted value to what stands in its place."""
    found = [each for each in _ATTRIBUTE.finditer(text) if not only or re.fullmatch(only, each[1])]
    if not found:
        return text
    one = chance.choice(found)
    return text[: one.start()] + change(one[1], one[2]) + text[one.end() :]


def _element(text: str, chance: random.Random, change: Callable[[str], str], tags: str) -> str:
    """Changes one element, with all that it holds."""
    found = list(re.finditer(rf"<({tags})\b[^>]*?(/>|>.*?</\1>)", text, re.DOTALL))
    if not found:
        return text
    one = chance.choice(found)
    return text[: one.start()] + change(one[0]) + text[one.end() :]


PARTS = "axis|limit|inertial|origin|visual|collision|mimic|dynamics|material|geometry|parent|child|mass|inertia"
NUMERIC = "xyz|rpy|lower|upper|velocity|effort|multiplier|offset|radius|length|size|rgba|value|i[xyz]{2}|scale|damping"


def drop_attribute(text: str, chance: random.Random) -> str:
    """An attribute is missing."""
    return _attribute(text, chance, lambda name, value: "")


def drop_element(text: str, chance: random.Random) -> str:
    """A part of a link or joint is missing."""
    return _element(text, chance, lambda element: "", PARTS)


def double_element(text: str, chance: random.Random) -> str:
    """A part stands twice."""
    return _element(text, chance, lambda element: element * 2, PARTS)


def double_member(text: str, chance: random.Random) -> str:
    """A link or a joint stands twice."""
    return _element(text, chance, lambda element: element * 2, "link|joint")


def drop_member(text: str, chance: random.Random) -> str:
    """A link or a joint is missing."""
    return _element(text, chance, lambda element: "", "link|joint")


def shuffle_members(text: str, chance: random.Random) -> str:
    """Links and joints stand in any order."""
    found = list(re.finditer(r"<(link|joint)\b[^>]*?(?<!/)>.*?</\1>", text, re.DOTALL))
    order = [each[0] for each in found]
    chance.shuffle(order)
    pieces, place = [], 0
    for each, instead in zip(found, order):
        pieces += [text[place : each.start()], instead]
        place = each.end()
    return "".join(pieces) + text[place:]


def reverse_limits(text: str, chance: random.Random) -> str:
    """Lower is upper and upper is lower."""
    return _element(
        text,
        chance,
        lambda limit: re.sub(r"lower|upper", lambda m: {"lower": "upper"}.get(m[0], "lower"), limit),
        "limit",
    )


def spoil_number(text: str, chance: random.Random) -> str:
    """One of several numbers is none, or written in a way of one's own."""

    def change(name: str, value: str) -> str:
        words = value[1:-1].split() or [""]
        words[chance.randrange(len(words))] = chance.choice(NUMBERS)
        return f" {name}={value[0]}{' '.join(words)}{value[0]}"

    return _attribute(text, chance, change, NUMERIC)


def count_numbers_wrong(text: str, chance: random.Random) -> str:
    """One number too many or too few."""

    def change(name: str, value: str) -> str:
        words = value[1:-1].split()
        words = chance.choice([[*words, "1"], words[:-1], words * 2, words[:1]])
        return f" {name}={value[0]}{' '.join(words)}{value[0]}"

    return _attribute(text, chance, change, NUMERIC)


def separate_otherwise(text: str, chance: random.Random) -> str:
    """Commas, tabs, ends of lines or blanks stand between numbers."""
    between = chance.choice([",", ", ", ";", "\t", "\n", "  ", "\u00a0"])
    return _attribute(
        text, chance, lambda name, value: f" {name}={value[0]}{between.join(value[1:-1].split())}{value[0]}", NUMERIC
    )


def rename(text: str, chance: random.Random) -> str:
    """One name is another."""
    return _attribute(text, chance, lambda name, value: f' {name}="{chance.choice(NAMES)}"', "name|link|joint|filename")


def change_type(text: str, chance: random.Random) -> str:
    """A joint is of another type, or of one that is written otherwise."""
    types = (
        "Revolute",
        "revolute ",
        "continuous",
        "fixed",
        "floating",
        "planar",
        "spherical",
        "",
        "prismatic",
        "hinge",
    )
    return _attribute(text, chance, lambda name, value: f' {name}="{chance.choice(types)}"', "type")


def quote_otherwise(text: str, chance: random.Random) -> str:
    """Single quotes, blanks around =, no blank before, no quotes."""
    forms = (" {0}='{1}'", ' {0} = "{1}"', '{0}="{1}"', " {0}={1}", "\n{0}\n=\n'{1}'\n", " {0}=\u201c{1}\u201d")
    return _attribute(text, chance, lambda name, value: chance.choice(forms).format(name, value[1:-1]))


def spell_otherwise(text: str, chance: random.Random) -> str:
    """A tag or an attribute in upper case, or with a prefix."""
    tag = chance.choice(sorted({found[1] for found in _TAG.finditer(text)} or {"robot"}))
    instead = chance.choice([tag.upper(), tag.capitalize(), f"u:{tag}", f"{tag}s"])
    if chance.random() < 0.5:
        return _attribute(text, chance, lambda name, value: f" drake:{name}={value}")
    return re.sub(rf"(</?){tag}\b", rf"\g<1>{instead}", text)


def add_junk(text: str, chance: random.Random) -> str:
    """Elements of other programs, comments and text that XML forbids."""
    return _somewhere(text, chance, chance.choice(JUNK))


def add_attribute(text: str, chance: random.Random) -> str:
    """An attribute that URDF does not have."""
    more = chance.choice(
        [" drake:a='1'", " a='&'", " quat_xyzw='0 1 0 1'", " version='1.1'", " xmlns='http://x'", " a=''"]
    )
    tags = list(_TAG.finditer(text))
    if not tags:
        return text
    place = chance.choice(tags).end(1)
    return text[:place] + more + text[place:]


def break_shape(text: str, chance: random.Random) -> str:
    """A shape or a colour that cannot be."""
    shape = f"<geometry>{chance.choice(SHAPES)}</geometry>"
    part = chance.choice(["visual", "collision"])
    return text.replace("</link>", f"<{part}>{shape}</{part}></link>", 1)


def break_mimic(text: str, chance: random.Random) -> str:
    """A joint follows nobody, itself, or another one."""
    names = re.findall(r"<joint\s+name=\"([^\"]*)\"", text) or ["j"]
    more = chance.choice(["", " multiplier='2'", " multiplier='x'", " offset='0,1'", " multiplier='0'"])
    mimic = f"<mimic joint='{chance.choice([*names, 'nobody', ''])}'{more}/>"
    places = [found.start() for found in re.finditer("</joint>", text)]
    place = chance.choice(places) if places else 0
    return text[:place] + mimic + text[place:]


def change_head(text: str, chance: random.Random) -> str:
    """What stands before the root element."""
    return chance.choice(HEADS) + re.sub(r"^\s*<\?xml.*?\?>", "", text)


def change_tail(text: str, chance: random.Random) -> str:
    """What stands after the root element, or is cut off."""
    return text[: -chance.randrange(1, 30)] if chance.random() < 0.2 else text.rstrip() + chance.choice(TAILS)


def change_lines(text: str, chance: random.Random) -> str:
    """Other ends of lines, or none."""
    return text.replace("\r\n", "\n").replace("\n", chance.choice(["\r\n", "\r", " ", "\n\n"]))


MISTAKES: tuple[Mistake, ...] = (
    drop_attribute, drop_element, double_element, double_member, drop_member, shuffle_members, reverse_limits,
    spoil_number, count_numbers_wrong, separate_otherwise, rename, change_type, quote_otherwise, spell_otherwise,
    add_junk, add_attribute, break_shape, break_mimic, change_head, change_tail, change_lines,
)  # fmt: skip


def mutated(seed: int) -> tuple[str, bytes, str]:
    """What was done, the file, and the tip of the robot it came from."""
    chance = random.Random(seed)
    text, tip = chance.choice(bases())
    made = [MISTAKES[seed % len(MISTAKES)], *chance.choices(MISTAKES, k=chance.choice([0, 0, 0, 1, 1, 2]))]
    for mistake in made:
        text = mistake(text, chance)
    encoding = "utf-8" if chance.random() < 0.8 else chance.choice(ENCODINGS)
    return f"{' '.join(each.__name__ for each in made)}, {encoding}", text.encode(encoding, "replace"), tip


# ------------------------------------------------------------------------------------------------ held against it
@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Pinocchio's reader writes to the process's standard error."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def oracle(data: bytes) -> pin.Model | None:
    """What Pinocchio makes of a file, if anything."""
    text = _decoded(data)
    with _quiet():
        try:
            return pin.buildModelFromXML(text)
        except (ValueError, RuntimeError, UnicodeError):
            return None


def _decoded(data: bytes) -> str:
    for encoding in ("utf-8", "cp1252"):
        with contextlib.suppress(UnicodeDecodeError):
            return data.decode(encoding)
    return data.decode("latin-1")


def failure(data: bytes, tip: str, seed: int) -> str:
    """What is wrong with how a file was taken; empty if nothing is."""
    model = oracle(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            robot = rik.Robot.from_description(parse_urdf(data), tip)
            q = robot.random(np.random.default_rng(seed))
            pose = robot.pose(q)
    except rik.RobustIKError as error:
        return _refusal(str(error), model, tip)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    if not np.isfinite(pose).all():
        return "the pose is not finite"
    differs = ("<axis> without xyz", "the normal of its plane is")  # Pinocchio: an axis of no length, a plane across z
    if model is None or any(said in note for said in differs for note in robot.notes):
        return ""
    return _difference(robot, q, pose, model, tip)


def _refusal(message: str, model: pin.Model | None, tip: str) -> str:
    if "\n" in message or len(message) > 1500:
        return f"a message of {len(message)} characters in {message.count(chr(10)) + 1} lines"
    if model is None or any(re.search(reason, message) for reason in STATED):
        return ""
    if not model.existBodyName(tip) and "no link or joint" in message:
        return ""
    return f"Pinocchio reads it: {message}"


def _difference(robot: rik.Robot, q: np.ndarray, pose: np.ndarray, model: pin.Model, tip: str) -> str:
    """How the chain to the tip differs from Pinocchio's, with followers following and all else at zero."""
    if not model.existBodyName(tip):
        return ""
    frame = model.getFrameId(tip, pin.FrameType.BODY)
    moving = {model.names[joint] for joint in model.supports[model.frames[frame].parentJoint] if joint}
    ours = {joint.part_of or joint.name for joint in robot.description.chain(tip) if joint.kind != "fixed"}
    if moving != ours:
        return f"the joints differ: {sorted(moving ^ ours)[:5]}"
    values = dict(zip(robot.joint_names, robot.joint_values(q)))
    positions = pin.neutral(model)
    for name in ours:
        if parts := robot.description.parts.get(name):
            joint, at = model.joints[model.getJointId(name)], np.array([values[part] for part in parts])
            positions[joint.idx_q : joint.idx_q + joint.nq] = _of_parts(at)
            continue
        driver = robot.description.driver[name]
        value = values[driver.source] * driver.multiplier + driver.offset
        joint = model.joints[model.getJointId(name)]
        turns = joint.nq == 2
        positions[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(value), np.sin(value)] if turns else [value]
    data = model.createData()
    pin.framesForwardKinematics(model, data, positions)
    error = float(np.abs(data.oMf[frame].homogeneous - pose).max())
    return "" if error <= 1e-9 * max(1.0, float(np.abs(pose).max())) else f"the poses differ by {error:.3g}"


def _of_parts(at: np.ndarray) -> np.ndarray:
    """Pinocchio's configuration of a planar (x, y, yaw) or floating joint (x, y, z, yaw, pitch, roll)."""
    if len(at) == 3:
        return np.array([*at[:2], np.cos(at[2]), np.sin(at[2])])
    return np.append(at[:3], pin.Quaternion(pin.rpy.rpyToMatrix(*at[:2:-1])).coeffs())


def attack(count: int, seed: int, say: Callable[[str], None]) -> list[str]:
    """Mutates so many files and says what failed.

    Args:
        count: How many files.
        seed: The first one's; the same seed makes the same file.
        say: Is told now and then how far it is.

    Returns:
        The failures, a sentence each; none if all is well.
    """
    failures: list[str] = []
    logging.getLogger("robust_ik").addHandler(nothing := logging.NullHandler())  # else notes go to standard error
    for done in range(count):
        number = seed * APART + done
        made, data, tip = mutated(number)
        if problem := failure(data, tip, number):
            failures.append(f"mistaken file {number} ({made}): {problem}")
        if (done + 1) % 200 == 0:
            say(f"{done + 1} of {count} mistaken files, {len(failures)} failures")
    logging.getLogger("robust_ik").removeHandler(nothing)
    return failures
