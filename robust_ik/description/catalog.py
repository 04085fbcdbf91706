"""The catalogue of robots that can be loaded by name: ours in `robots/`, and those of example-robot-data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path, PurePosixPath
from types import MappingProxyType

from robust_ik.errors import RobotNotFoundError, suggest

OURS = "robust_ik"
EXAMPLES = "example-robot-data"

# File (below example-robot-data's robots/) → name, if the file's own name is ambiguous or clumsy.
_NAMES = {
    "anymal_b_simple_description/robots/anymal.urdf": "anymal_b",
    "anymal_b_simple_description/robots/anymal-kinova.urdf": "anymal_kinova",
    "anymal_c_simple_description/urdf/anymal.urdf": "anymal_c",
    "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf": "alexander_lower_body",
    "asr_twodof_description/urdf/TwoDofs.urdf": "asr_twodof",
    "borinot_description/urdf/borinot_flying_arm_2.urdf": "borinot",
    "b1_description/urdf/b1-z1.urdf": "b1_z1",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf": "g1",
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf": "g1_with_hands",
    "hector_description/robots/quadrotor_base.urdf": "hector",
    "hextilt_description/urdf/hextilt_flying_arm_5.urdf": "hextilt",
    "hyq_description/robots/hyq_no_sensors.urdf": "hyq",
    "talos_data/robots/talos_full_v2.urdf": "talos",
    "talos_data/robots/talos_full_v2_box.urdf": "talos_box",
    "talos_data/robots/talos_left_arm.urdf": "talos_arm",
    "ur_description/urdf/ur3_robot.urdf": "ur3",
    "ur_description/urdf/ur5_robot.urdf": "ur5",
    "ur_description/urdf/ur10_robot.urdf": "ur10",
    "ur_description/urdf/ur3_joint_limited_robot.urdf": "ur3_limited",
    "ur_description/urdf/ur5_joint_limited_robot.urdf": "ur5_limited",
    "ur_description/urdf/ur10_joint_limited_robot.urdf": "ur10_limited",
}

# An empty file in the package.
_NOT_ROBOTS = ("ur_description/urdf/ur3.urdf",)


@dataclass(frozen=True)
class Known:
    """What is documented about a robot beyond its file.

    Attributes:
        tip: The manufacturer's tool frame.
        rest: A start configuration, joint values in rad or m; empty if none is documented.
    """

    tip: str
    rest: tuple[float, ...] = ()


# Tool frames: the flange or tool frame that each manufacturer's URDF documents.
_KNOWN = {
    "panda": Known("panda_hand_tcp", (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)),
    "panda_collision": Known("panda_hand_tcp", (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)),
    # J-PARSE's home position (reference code): arm bent, tool down.
    "xarm7": Known("link_eef", (-0.0314, -0.5166, 0.1204, 0.9198, -0.0314, 1.4172, 0.0349)),
    "kinova": Known("j2s6s200_end_effector"),
    "z1": Known("link06"),
    "so100": Known("gripper"),
    "so101": Known("gripper_frame_link"),
    "talos_arm": Known("gripper_left_base_link"),
    "tiago": Known("arm_tool_link"),
    "tiago_no_hand": Known("arm_tool_link"),
}


@dataclass(frozen=True)
class Entry:
    """A robot that can be loaded by name.

    Attributes:
        name: The name.
        path: Its URDF or DH file.
        source: Which collection it belongs to.
        known: What is documented about it, if anything.
    """

    name: str
    path: Path
    source: str
    known: Known | None = None


@cache
def catalog() -> Mapping[str, Entry]:
    """Every robot that can be loaded by name, ours first."""
    entries: dict[str, Entry] = {}
    for entry in (*_ours(), *_examples()):
        entries.setdefault(entry.name, entry)
    return MappingProxyType(entries)


def find(name: str) -> Entry:
    """The robot of that name.

    Raises:
        RobotNotFoundError: There is none; the message offers names.
    """
    try:
        return catalog()[name]
    except KeyError:
        if "/" in name or "\\" in name:
            raise RobotNotFoundError(
                f"{name[:200]!r} is no .urdf, .xacro or .toml file; 'robust-ik robots' lists names"
            ) from None
        shown = name if len(name) <= 200 else name[:200] + "…"
        raise RobotNotFoundError(
            f"there is no robot called {shown!r} and no file at that path; {suggest(name, catalog(), limit=100)}"
        ) from None


def _ours() -> Iterator[Entry]:
    """Our robots: in `robots/` beside the package in a checkout, in `_robots/` inside it when installed."""
    package = Path(__file__).parents[1]
    folder = next((f for f in (package / "_robots", package.parent / "robots") if f.is_dir()), None)
    if folder is None:
        return
    for path in sorted(folder.glob("*/*")):
        if path.suffix in (".toml", ".urdf") and path.stem == path.parent.name:
            yield Entry(path.stem, path, OURS)


def _examples() -> Iterator[Entry]:
    """The URDF files of the example-robot-data package, found on disk without importing it."""
    from importlib.metadata import PackageNotFoundError, distribution  # not needed for a robot that is given as a path

    try:
        files = distribution(EXAMPLES).files or []
    except PackageNotFoundError:
        return
    for file in sorted(files, key=str):
        if file.suffix == ".urdf" and "robots" in file.parts:
            key = PurePosixPath(*file.parts[file.parts.index("robots") + 1 :]).as_posix()
            if key not in _NOT_ROBOTS:
                name = _NAMES.get(key, file.stem)
                yield Entry(name, Path(str(file.locate())).resolve(), EXAMPLES, _KNOWN.get(name))
