"""Robot: a Pinocchio model with a tip and limits.

Default reference of Jacobians and Hessians: LOCAL_WORLD_ALIGNED (the tip's point, the world's axes).
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.checks.public_arguments import checked, checked_but
from robust_ik.description.dh.dh_table import DHTable
from robust_ik.description.joint_tree import Description
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf.urdf_reader import parse_urdf, read_urdf
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.robot.joint_map import JointMap
from robust_ik.robot.pinocchio_model import Kinematics, build_model, joints_to_keep
from robust_ik.robot.pose_inverse import PoseInverse
from robust_ik.runtime.files import checked_folders

LOGGER = logging.getLogger("robust_ik")
MOST_TOLD = 1000
_TOLD: set[str] = set()
"""The notes that were logged: reading a file again says nothing new."""


@dataclass(frozen=True, eq=False)
class Robot(PoseInverse):
    """A fixed-base arm or tree whose kinematics are functions of q.

    Configurations are in `configurations`, kinematics of frames in `frame_kinematics`, their inverse in `pose_inverse`.

    Attributes:
        name: What it is called.
        tip: The frame that is moved, or None for a whole tree without one.
        rows: The task rows that `jacobian` and `hessian` return by default, of x y z wx wy wz.
        description: Joints and shapes as read from the file.
        lower: Lower limits of the n joints, rad or m; −∞ where none is stated.
        upper: Upper limits of the n joints, rad or m; +∞ where none is stated.
        velocity_limit: Speed limits of the n joints, rad/s or m/s; +∞ where none is stated.
        rest: A configuration to start from, (nq,): the catalogue's, else zero moved inside the limits.
        guess: Why this tip was taken, where none was given and the choice is not plain; else empty.
    """

    name: str
    tip: str | None
    rows: tuple[str, ...]
    description: Description
    lower: Array
    upper: Array
    velocity_limit: Array
    rest: Array
    _kinematics: Kinematics = field(repr=False)
    _joints: JointMap = field(repr=False)
    guess: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "velocity_limit", "rest"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, so that copies are read-only too.
        return type(self), tuple(getattr(self, each.name) for each in fields(self))

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, n={self.n}, tip={self.tip!r}, rows={' '.join(self.rows)})"

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know of how the file was read and the tip chosen, a sentence each."""
        return self.description.notes + ((self.guess,) if self.guess else ()) + self._scale_note

    @property
    def _scale_note(self) -> tuple[str, ...]:
        if self.tip is None or self.length_scale == 1.0:
            return ()
        size, scale = f"{self.size:.3g}", f"{self.length_scale:.3g}"
        return (f"its links span {size} m: lengths are compared with angles in units of {scale} m (docs/scale.md)",)

    def _told(self) -> Self:
        """The robot, after its notes were logged; a note of a file is logged once."""
        for note in self.notes:
            said = f"{self.description.source}: {note}"
            if said not in _TOLD:
                if len(_TOLD) >= MOST_TOLD:
                    _TOLD.clear()
                _TOLD.add(said)
                LOGGER.warning("%s", said)
        return self

    # ------------------------------------------------------------------------------------------ construction
    @classmethod
    @checked_but("xacro_args")
    def from_urdf(
        cls,
        path: str | Path,
        tip: str | None = None,
        *,
        package_dirs: Sequence[str | Path] = (),
        rows: Sequence[str] = ROWS,
        whole_tree: bool = False,
        xacro_args: Mapping[str, object] | None = None,
    ) -> Self:
        """A robot from a URDF file, or from a `.xacro` file where xacrodoc is installed.

        Args:
            path: The file.
            tip: Link or joint frame to move; by default the end of the one arm, and `notes` say where it was guessed.
            package_dirs: Where packages lie that mesh paths name.
            rows: Task rows, of x y z wx wy wz.
            whole_tree: Keep every joint, also those that do not move the tip; then the tip may be left out.
            xacro_args: Values of the arguments of a `.xacro` file.

        Raises:
            RobotNotFoundError: There is no such file.
            UrdfError: The file is broken, unsafe or not supported.
            TipError: The tip is ambiguous, or no joint moves it.
            FrameNotFoundError: There is no such tip.
        """
        description = read_urdf(path, checked_folders(package_dirs, "package_dirs"), xacro_args)
        return cls.from_description(description, tip, rows=rows, whole_tree=whole_tree)

    @classmethod
    @checked
    def from_dh(cls, table: DHTable) -> Self:
        """A robot from a Denavit-Hartenberg table, by way of a URDF; its tip is the link "tool"."""
        from robust_ik.description.dh.dh_urdf import dh_to_urdf

        description = parse_urdf(dh_to_urdf(table), source=f"the URDF of DH table {table.name}")
        robot = cls.from_description(description, "tool", rows=table.rows)
        return replace(
            robot,
            lower=table.lower,
            upper=table.upper,
            velocity_limit=table.velocity,
            rest=np.clip(0.0, table.lower, table.upper) if table.rest is None else table.rest,
        )

    @classmethod
    def from_description(
        cls,
        description: Description,
        tip: str | None = None,
        *,
        rows: Sequence[str] = ROWS,
        whole_tree: bool = False,
    ) -> Self:
        """A robot from a checked description; arguments and errors as for `from_urdf`."""
        guess = ""
        if tip is None and not whole_tree:
            chosen = choose_tip(description)
            tip, guess = chosen.name, chosen.note
        keep = joints_to_keep(description, None if whole_tree else tip)
        model = build_model(description, keep)
        joints = JointMap.of(description, list(model.names)[1:])
        lower, upper, velocity = joints.limits(description, list(model.names)[1:])
        return cls(
            name=description.name,
            tip=tip,
            rows=checked_rows(rows),
            description=description,
            lower=lower,
            upper=upper,
            velocity_limit=velocity,
            rest=joints.configuration(np.clip(0.0, lower, upper)),
            _kinematics=Kinematics(model),
            _joints=joints,
            guess=guess,
        )._told()

    def with_rows(self, rows: Sequence[str]) -> Robot:
        """The same robot with other task rows."""
        return replace(self, rows=checked_rows(rows))
