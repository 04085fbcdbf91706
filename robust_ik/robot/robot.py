"""Robot: made from files and tables, with a rest, its kinematics, its inverse kinematics and the way out.

Its joints and frames are those of `RobotKinematics`.
"""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self, Unpack

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.branches import AllSolutions, BranchSolver, ManySolutions
from robust_ik.checks import as_measures, check_leading_axes, checked_parameter, is_plain
from robust_ik.checks.public_arguments import checked, checked_but
from robust_ik.description.dh import DHTable
from robust_ik.description.joint_tree import Description
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf import parse_urdf, read_urdf
from robust_ik.errors import InputError
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.paths import PathPlan, PathPlanner
from robust_ik.paths.layer_solver import LayerSolver
from robust_ik.pose_ik import (
    PoseOptions,
    PoseResult,
    PoseResults,
    PoseSolver,
    as_poses,
    is_plain_pose,
    is_position,
    wanted_rows,
)
from robust_ik.robot.default_rest import SAMPLES, default_rest
from robust_ik.robot.joint_map import JointMap
from robust_ik.robot.path_arguments import path_arguments
from robust_ik.robot.pinocchio_model import PinocchioModel, build_model, joints_to_keep
from robust_ik.robot.robot_kinematics import RobotKinematics
from robust_ik.robot.solution_search import ManyStarts
from robust_ik.robot.way_out import SINGULAR, Families, WayOut, way_out
from robust_ik.runtime.files import checked_folders
from robust_ik.runtime.warn_once import warn_once


@dataclass(frozen=True, eq=False)
class Robot(RobotKinematics):
    """An arm or a tree, on a base that may move, whose kinematics are functions of q.

    Attributes:
        name: Name of the robot.
        tip: The frame that is moved, or None for a whole tree without one.
        rows: The task rows that `jacobian` and `hessian` return by default, of x y z wx wy wz.
        description: Joints and shapes as read from the file.
        lower: Lower limits of the n joints, rad or m; −∞ if not stated.
        upper: Upper limits of the n joints, rad or m; +∞ if not stated.
        velocity_limit: Speed limits of the n joints, rad/s or m/s; +∞ if not stated.
        rest: A start configuration, (nq,): the catalogue's, else zero within the limits, bent where a motion is lost.
        guess: Why this tip was chosen, if none was given and the choice is not clear; else empty.
    """

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, n={self.n}, tip={self.tip!r}, rows={' '.join(self.rows)})"

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know about how the file was read and the tip chosen, one sentence each."""
        return self.description.notes + ((self.guess,) if self.guess else ()) + self._scale_note

    @property
    def _scale_note(self) -> tuple[str, ...]:
        if self.tip is None or self.length_scale == 1.0:
            return ()
        size, scale = f"{self.size:.3g}", f"{self.length_scale:.3g}"
        return (f"its links span {size} m: lengths are compared with angles in units of {scale} m (docs/scale.md)",)

    # -------------------------------------------------------------------------------------------------- construction
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
        """A robot from a URDF file, or from a `.xacro` file if xacrodoc is installed.

        Args:
            path: The file.
            tip: Link or joint frame to move; by default the end of the one arm, and `notes` say if it was guessed.
            package_dirs: Folders of packages for mesh paths.
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
        """A robot from a Denavit-Hartenberg table, converted to a URDF; its tip is the link "tool"."""
        from robust_ik.description.dh import dh_to_urdf

        description = parse_urdf(dh_to_urdf(table), source=f"the URDF of DH table {table.name}")
        robot = cls.from_description(description, "tool", rows=table.rows)
        robot = replace(robot, lower=table.lower, upper=table.upper, velocity_limit=table.velocity)
        return robot.with_default_rest() if table.rest is None else replace(robot, rest=table.rest)

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
        robot = cls(
            name=description.name,
            tip=tip,
            rows=checked_rows(rows),
            description=description,
            lower=lower,
            upper=upper,
            velocity_limit=velocity,
            rest=joints.configuration(np.clip(0.0, lower, upper)),
            _pinocchio=PinocchioModel(model, joints),
            _joints=joints,
            guess=guess,
        )
        warn_once(description.source, robot.notes)
        return robot.with_default_rest()

    def with_default_rest(self) -> Self:
        """The same robot with `rest` at zero, or near it if the tip has lost a motion at zero.

        A robot without a tip rests at zero.
        """
        if self.tip is None:
            return replace(self, rest=self.configuration(np.clip(0.0, self.lower, self.upper)))
        weights = np.array([1.0 if row in ROWS[:3] else self.length_scale for row in self.rows])[:, None]
        values = default_rest(
            lambda values: weights * self.jacobian(self.configuration(values)),
            self.lower,
            self.upper,
            np.where(self.sliding, self.length_scale / 4, np.pi / 4),
            self.joint_values(self.random(np.random.default_rng(0), SAMPLES)),
        )
        return replace(self, rest=self.configuration(values))

    def with_rows(self, rows: Sequence[str]) -> Robot:
        """The same robot with other task rows."""
        return replace(self, rows=checked_rows(rows))

    # -------------------------------------------------------------------------------------------- inverse kinematics
    @cached_property
    def _pose_solvers(self) -> dict[tuple[str | None, tuple[str, ...]], PoseSolver]:
        return {}

    @cached_property
    def _branch_solvers(self) -> dict[tuple[str | None, tuple[str, ...]], BranchSolver]:
        return {}

    @cached_property
    def _find_quickly(self) -> Callable[[Any, Any], AllSolutions | None]:
        return self.branch_solver().quickly

    @cached_property
    def _solve_quickly(self) -> Callable[[Any, Any], PoseResult | None]:
        return self.pose_solver().quickly

    @cached_property
    def _solve_position_quickly(self) -> Callable[[Any, Any], PoseResult | None]:
        return self.pose_solver(rows=wanted_rows(np.zeros(3), None, self.rows)).quickly

    def pose_solver(self, frame: str | None = None, rows: Sequence[str] | None = None) -> PoseSolver:
        """The solver behind `solve_pose`, for loops that call it often; made once for each frame and rows.

        Args:
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`.
        """
        names = self.rows if rows is None else checked_rows(rows)
        if not isinstance(frame, (str, type(None))):
            raise InputError(f"a frame is named by a str, got {reprlib.repr(frame)}")
        solver = self._pose_solvers.get((frame, names))
        if solver is None:
            solver = PoseSolver(self.chain(frame), self.lower, self.upper, self.rest, names, self.length_scale)
            self._pose_solvers[frame, names] = solver
        return solver

    def solve_pose(
        self,
        target: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        **options: Unpack[PoseOptions],
    ) -> PoseResult:
        """Inverse kinematics: a configuration within joint limits whose pose is the target, or the closest to it.

        The closest pose has the least E = ‖Δp‖² + L² ‖Δr‖², in m and rad, over the wanted rows, where L is
        `length_scale`, by default the robot's: 1 m per rad for robots of usual size.

        Args:
            target: A pose (4, 4), or a position (3,), m; then rotations are free.
            q0: Where the search begins, (nq,); default `self.rest`. Joints outside their limits are moved inside;
                joints that do not move the frame stay.
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`. With two of the rotations, the frame
                may turn freely about the third world axis.
            **options: See `PoseOptions`: preference, number of solutions, effort, tolerances.

        Returns:
            The configuration, a status (solved, closest, out of reach), the remaining error, the work done.

        Raises:
            InputError: An argument is not valid, or more than 16 joints move the frame.
            FrameNotFoundError: There is no such frame.
        """
        if frame is None and rows is None and not options:
            solve = self._solve_position_quickly if is_position(target) else self._solve_quickly
            found = solve(target, q0)
            if found is not None:
                return found
        solver = self.pose_solver(frame, wanted_rows(target, rows, self.rows))
        found = None if options else solver.quickly(target, q0)
        return solver.solve(target, q0, **options) if found is None else found

    def branch_solver(self, frame: str | None = None, rows: Sequence[str] | None = None) -> BranchSolver:
        """The solver behind `all_solutions`, for loops that call it often; made once for each frame and rows.

        Args:
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`.
        """
        names = self.rows if rows is None else checked_rows(rows)
        pose_solver = self.pose_solver(frame, names)
        solver = self._branch_solvers.get((frame, names))
        if solver is None:
            joints, chain = self._joints, self.chain(frame)
            search = ManyStarts(pose_solver, joints)
            solver = BranchSolver(chain, self.lower, self.upper, names, self.joint_names, joints.configuration, search)
            self._branch_solvers[frame, names] = solver
        return solver

    def all_solutions(
        self,
        target: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        turns: bool = False,
    ) -> AllSolutions:
        """Every configuration that reaches a pose, and whether it is shown that there are no others.

        Arms of up to six joints are solved by elimination: one equation for one joint, in closed form where three
        neighbouring axes meet or are parallel, with up to 16 roots otherwise. Arms with one joint more give the
        self-motions of the pose. Where a joint follows another one, a search from many starts says what it finds.

        Args:
            target: A pose (4, 4), or a position (3,), m; then rotations are free.
            q0: What solutions are sorted by, and turns chosen next to, (nq,); default `self.rest`. Joints that do
                not move the frame stay there.
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`.
            turns: Also give what differs by full turns of joints, within finite limits; the nearest first.

        Returns:
            The solutions within limits and beyond them, with a status and the self-motions of a singular pose.

        Raises:
            InputError: An argument is not valid.
            FrameNotFoundError: There is no such frame.
        """
        if not isinstance(turns, (bool, np.bool_)):
            raise InputError(f"turns must be True or False, got {turns!r}")
        start = self.rest if q0 is None else q0
        plain = is_plain_pose(target) and is_plain(start, self.nq)
        if plain and frame is None and rows is None and not turns:
            found = self._find_quickly(target, self.joint_values(start))
            if found is not None:
                return found
        solver = self.branch_solver(frame, wanted_rows(target, rows, self.rows))
        poses = as_poses(target, self.length_scale)
        if poses.ndim != 2:
            raise InputError(
                f"target must be a pose (4, 4) or a position (3,), got shape {np.shape(target)}; "
                "all_solutions_many takes many targets"
            )
        near = self.joint_values(start)
        if near.ndim != 1:
            raise InputError(f"q0 must be one configuration ({self.nq},), got shape {near.shape}")
        every = solver.solve(poses, near)
        return solver.with_turns(every, self.joint_values(every.q), near) if turns else every

    def all_solutions_many(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
    ) -> ManySolutions:
        """`all_solutions` for many targets in one compiled call, without tracing self-motions of singular poses.

        Args:
            targets: Poses (..., 4, 4) or positions (..., 3).
            q0: As for `all_solutions`, (..., nq), leading axes broadcast.
            frame: As for `all_solutions`.
            rows: As for `all_solutions`.
        """
        solver = self.branch_solver(frame, wanted_rows(targets, rows, self.rows, many=True))
        poses = as_poses(targets, self.length_scale)
        near = self.joint_values(self.rest if q0 is None else q0)
        check_leading_axes("targets", poses.shape[:-2], "q0", near.shape[:-1])
        shape = np.broadcast_shapes(poses.shape[:-2], near.shape[:-1])
        return solver.solve_many(np.broadcast_to(poses, (*shape, 4, 4)), near)

    def path_planner(self, frame: str | None = None, rows: Sequence[str] | None = None) -> PathPlanner:
        """The planner behind `plan_path`, of a frame, default the tip, in rows, default `self.rows`."""
        search, branches = ManyStarts(self.pose_solver(frame, rows), self._joints), self.branch_solver(frame, rows)
        return PathPlanner(LayerSolver(branches, search.closest, self._joints.values, self.length_scale))

    def plan_path(
        self,
        poses: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        start: ArrayLike | None = None,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        accuracy: float | None = None,
    ) -> PathPlan:
        """A continuous joint motion through poses, on all branches at once; else how far it goes and why no further.

        Between two poses the frame's point moves on a line, and it turns about a fixed axis. The shortest motion is
        found through all solutions of the poses and of places between, full turns counted. Each step is looked at in
        between and made finer until the frame stays on the path; one that does not is a jump and is not taken. Where
        no motion follows the whole path, the pieces are those that each go as far as any.

        Args:
            poses: Poses (p, 4, 4) or positions (p, 3).
            q0: Where the motion should begin if motions are equally short, (nq,); default `self.rest`.
            start: Where the motion must begin, (nq,); default anywhere.
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`.
            accuracy: How far the frame may leave the path, m, and rad times the length scale; default 1e-4 of it.

        Returns:
            The motion, or pieces of it, and why each one ends.

        Raises:
            InputError: An argument is not valid; start is not at the first pose; neighbours are half a turn apart.
            FrameNotFoundError: There is no such frame.
        """
        planner = self.path_planner(frame, wanted_rows(poses, rows, self.rows, many=True))
        return planner.plan(*path_arguments(self, poses, self.rest if q0 is None else q0, start, accuracy))

    def way_out(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        threshold: float = SINGULAR,
        atlas: Families | None = None,
    ) -> WayOut:
        """Whether and how a commanded motion can be followed from q, also where first order says that it is lost.

        Args:
            q: Configuration, (nq,).
            twist: The command in the rows, (m,), m/s and rad/s at the frame's point in world axes; its length does not
                matter.
            frame: Link or joint; default the tip.
            rows: Task rows; default `self.rows`.
            threshold: σ/σ₁ up to which a direction counts as lost, above 0 and below 1.
            atlas: A `SingularityAtlas` of the robot; what it says of the nearest family stands beside the verdict.

        Returns:
            A verdict (fold, both ways, turn first, end of reach, structural, free) with the joint motion.
        """
        checked_parameter("threshold", threshold, above=0, below=1)
        names = self.rows if rows is None else checked_rows(rows)
        q, twist = self._checked(q), as_measures(twist, "twist", (len(names),))
        if q.ndim != 1 or twist.ndim != 1:
            raise InputError(f"one q and one twist are needed, got shapes {q.shape} and {twist.shape}")
        found = way_out(self, q, twist, frame, names, threshold)
        if atlas is None:
            return found
        if not isinstance(atlas, Families):
            raise InputError(f"atlas must be a SingularityAtlas, got {reprlib.repr(atlas)}")
        if frame is not None or names != self.rows:
            raise InputError("an atlas is about the robot's tip and rows: give neither frame nor rows with it")
        return replace(found, family=atlas.said_of(q))

    def solve_poses(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        threads: int = 1,
        executor: Executor | None = None,
        progress: Callable[[int, int], None] | None = None,
        **options: Unpack[PoseOptions],
    ) -> PoseResults:
        """`solve_pose` for many targets, with the same bits, several times faster than one by one.

        Args:
            targets: Poses (..., 4, 4) or positions (..., 3).
            q0: Where the searches begin, (..., nq), leading axes broadcast.
            frame: As for `solve_pose`.
            rows: As for `solve_pose`.
            threads: Number of threads.
            executor: An executor that runs the pieces instead: processes, or a cluster.
            progress: Called with (pieces done, pieces in all).
            **options: As for `solve_pose`.
        """
        solver = self.pose_solver(frame, wanted_rows(targets, rows, self.rows, many=True))
        return solver.solve_many(targets, q0, threads=threads, executor=executor, progress=progress, **options)
