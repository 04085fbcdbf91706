"""Reads scenarios from TOML files, which are data only: nothing in them is run."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from robust_ik.checks import Array, as_array
from robust_ik.control.reaching import Reach
from robust_ik.control.tasks import Follow, FrameTask, OrientationTask, PostureTask, Replay, Stack, Task, pose
from robust_ik.description.toml_size_limits import read_toml
from robust_ik.errors import InputError, LoadError
from robust_ik.robot.loading import load
from robust_ik.robot.robot import Robot
from robust_ik.runtime.files import read_file
from robust_ik.simulation.scenario import Scenario
from robust_ik.simulation.scenarios.method_tables import method
from robust_ik.simulation.scenarios.target_tables import Table, target

LARGEST_FILE = 1_000_000
"""Most bytes of a file. Chosen: three hundred times the largest of ours (3 kB)."""


def read_scenario(path: str | Path) -> Scenario:
    """A scenario from a TOML file.

    ```toml
    title = "Out of reach and back"
    source = "where it is from"           # may be left out, as may what follows
    note = "what was chosen for missing information"
    angles = "deg"                        # or "rad", the default: all angles below

    [robot]
    name = "xarm7"                        # a name, or the path of a .urdf or DH .toml as seen from this file
    tip = "link_eef"                      # may be left out
    rows = ["x", "y", "z"]                # task rows; may be left out

    [start]
    joints = [0, 0, 0, 90, 0, 45, 0]      # values of all joints; default the robot's rest

    [target]                              # kinds: keypoints, line, arc, sinusoid, hold; twists, see below
    kind = "line"
    to = [0.5, 0, 0.4]
    speed = 0.1

    [control]
    gain = 5.0                            # 1/s
    max_linear = 0.1                      # m; likewise max_angular; may be left out, as may what follows
    feedforward = true
    reach = true                          # go round where the straight way ends (`Reach`); default a plain servo
    dt = 0.01
    duration = 20.0                       # default that of the path
    limits = true                         # the robot's own; default none

    [orientation]                         # a second level that holds an orientation; may be left out
    rpy = [0, 0, 90]                      # default that of the start
    rows = ["wx", "wy"]                   # may be left out
    gain = 2.0

    [posture]                             # a level below that; may be left out
    joints = [0, 0, 0, 0, 0, 0, 0]
    gain = 2.0

    [methods]
    "J-PARSE" = { type = "JParse", gamma = 0.1 }
    "J-PARSE, from limits" = { type = "JParse.from_limits", speed_limit = 1.0, task_speed = 0.2 }
    ```

    With `kind = "twists"` the tip has no target but commands, a `Replay`: `samples = [[0, 0.1, 0, 0, 0, 0, 0], …]`,
    rows of a time in seconds and a twist (linear in m/s, angular always in rad/s); then [control] has no gain.

    Args:
        path: The file; its stem is the scenario's name.

    Raises:
        RobotNotFoundError: There is no such file, or no such robot.
        LoadError: It is no TOML, or the robot cannot be loaded.
        InputError: A key is unknown or missing, or a value is not valid.
    """
    full, content = read_file(path, LARGEST_FILE)
    try:
        data = read_toml(content.decode("utf-8-sig"))
    except ValueError as error:
        raise LoadError(f"{full} is no TOML: {error}") from error
    try:
        return _scenario(full, Table(data, "the scenario"))
    except InputError as error:
        raise InputError(f"{full}: {error}") from error


def _scenario(path: Path, table: Table) -> Scenario:
    unit = _unit(table.get("angles", "rad"))
    robot = _robot(path.parent, Table(table.need("robot"), "robot"))
    q0 = _joints(robot, Table(table.get("start", {}), "start"), unit)
    way = target(table.need("target"), "target", robot.pose(q0), unit)
    control = Table(table.get("control", {}), "control")
    below = _below(robot, table, robot.pose(q0), unit)
    motion = _motion(way, control, below)
    methods = Table(table.get("methods", {}), "methods").data
    scenario = Scenario(
        name=path.stem,
        robot=robot,
        q0=q0,
        motion=motion,
        duration=control.number("duration", way.duration),
        dt=control.number("dt", 0.01),
        limits=None if _flag(control, "limits") else (),
        title=_text(table, "title"),
        source=_text(table, "source"),
        note=_text(table, "note"),
        methods={label: method(value, f"methods.{label}") for label, value in methods.items()},
    )
    control.done()
    table.done()
    return scenario


def _motion(way: Any, control: Table, below: Stack) -> Follow | Replay:
    """The path, followed by feedback, or recorded twists, which need none."""
    if isinstance(way, Replay):
        return replace(way, below=below)
    return Follow(
        way,
        gain=control.number("gain", 1.0),
        max_linear=control.get("max_linear", math.inf),
        max_angular=control.get("max_angular", math.inf),
        feedforward=control.get("feedforward", False),
        below=below,
        task=Reach if _flag(control, "reach") else FrameTask,
    )


def _flag(table: Table, key: str) -> bool:
    value = table.get(key, False)
    if not isinstance(value, bool):
        raise InputError(f"{table.where}.{key} must be true or false, got {value!r}")
    return value


def _unit(angles: object) -> float:
    if angles not in ("rad", "deg"):
        raise InputError(f'angles must be "rad" or "deg", got {angles!r}')
    return 1.0 if angles == "rad" else math.pi / 180


def _text(table: Table, key: str) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise InputError(f"{key} must be text, got {value!r}")
    return value


def _robot(folder: Path, table: Table) -> Robot:
    name = table.need("name")
    if not isinstance(name, str):
        raise InputError(f"robot.name must be a name or a path, got {name!r}")
    beside = folder / name
    file = name.lower().endswith((".urdf", ".xacro", ".toml")) and beside.is_file()
    robot = load(beside if file else name, table.get("tip"), rows=table.get("rows"))
    table.done()
    return robot


def _joints(robot: Robot, table: Table, unit: float) -> Array:
    """A configuration from joint values in the file's unit; lengths of sliding joints in m."""
    given = table.get("joints")
    table.done()
    if given is None:
        return robot.rest
    values = as_array(given, f"{table.where}.joints", (robot.n,))
    slides = np.array([robot.description.joint[name].kind == "prismatic" for name in robot.joint_names])
    return robot.configuration(np.where(slides, values, values * unit))


def _below(robot: Robot, table: Table, start: Array, unit: float) -> list[list[Task]]:
    """The levels below the path, if any."""
    levels: list[list[Task]] = []
    if table.get("orientation") is not None:
        levels.append([_orientation(Table(table.get("orientation"), "orientation", unit=unit), start)])
    if table.get("posture") is not None:
        levels.append([_posture(robot, Table(table.get("posture"), "posture"), unit)])
    return levels


def _orientation(table: Table, start: Array) -> OrientationTask:
    wanted = start if table.get("rpy") is None else pose((0, 0, 0), table.angles("rpy", (0.0, 0.0, 0.0)))
    task = OrientationTask(wanted[:3, :3], gain=table.number("gain", 1.0), rows=table.get("rows"))
    table.done()
    return task


def _posture(robot: Robot, table: Table, unit: float) -> PostureTask:
    options: dict[str, Any] = {"gain": table.number("gain", 1.0), "max_speed": table.get("max_speed", math.inf)}
    return PostureTask(_joints(robot, table, unit), **options)
