"""Robot: a Pinocchio model with a tip and limits, whose kinematics are functions of q.

Default reference of Jacobians and Hessians: LOCAL_WORLD_ALIGNED (the tip's point, the world's axes).
"""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, Self, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, alone, as_array, as_measures, check_leading_axes, checked_parameter, readonly
from robust_ik.checks.public_arguments import checked, checked_but
from robust_ik.description.dh import DHTable
from robust_ik.description.joint_tree import Description
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf import parse_urdf, read_urdf
from robust_ik.errors import InputError, TipError, listed
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.pose_ik import PoseOptions, PoseResult, PoseResults, PoseSolver, is_position, wanted_rows
from robust_ik.pose_ik.arm_size import find_size, is_usual, offsets_of, unit_of
from robust_ik.robot.default_rest import SAMPLES, default_rest
from robust_ik.robot.joint_map import JointMap
from robust_ik.robot.pinocchio_model import Data, Model, PinocchioModel, build_model, joints_to_keep
from robust_ik.robot.way_out import SINGULAR, WayOut, way_out
from robust_ik.runtime.files import checked_folders
from robust_ik.runtime.warn_once import warn_once

Reference = Literal["local", "world", "local_world_aligned"]


@dataclass(frozen=True, eq=False)
class Robot:
    """An arm or a tree, on a base that may move, whose kinematics are functions of q.

    It has two parts: a Pinocchio model, and a map from its independent joints to the joints of the model. Pinocchio
    computes single configurations. For many at once, compiled kernels work with constants of the model (`chain`); their
    results are Pinocchio's up to rounding.

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

    name: str
    tip: str | None
    rows: tuple[str, ...]
    description: Description
    lower: Array
    upper: Array
    velocity_limit: Array
    rest: Array
    _pinocchio: PinocchioModel = field(repr=False)
    _joints: JointMap = field(repr=False)
    guess: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "velocity_limit", "rest"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, since copies must be read-only too.
        return type(self), tuple(getattr(self, each.name) for each in fields(self))

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

    # -------------------------------------------------------------------------------------------------------- joints
    @property
    def n(self) -> int:
        """Number of independent joints, the length of q̇."""
        return len(self._joints.names)

    @property
    def nq(self) -> int:
        """Length of q: n plus the number of continuous joints, each of which is stored as (cos, sin)."""
        return self._joints.nq

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The independent joints, in the order of q̇."""
        return self._joints.names

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """Which of the independent joints slide, (n,)."""
        return self._joints.prismatic

    @property
    def neutral(self) -> Array:
        """The configuration of all joints at zero, (nq,); it may lie outside the limits."""
        return self._joints.configuration(np.zeros(self.n))

    def configuration(self, values: ArrayLike) -> Array:
        """Joint values (..., n) in rad or m → q (..., nq)."""
        return self._joints.configuration(as_array(values, "values", (self.n,)))

    def joint_values(self, q: ArrayLike) -> Array:
        """Configurations q (..., nq) → joint values (..., n) in rad or m; continuous joints in (−π, π]."""
        return self._joints.values(self._checked(q))

    def random(self, rng: np.random.Generator, size: int | tuple[int, ...] = ()) -> Array:
        """Uniform random configurations inside the limits, (*size, nq).

        Without stated limits: a full turn for a revolute joint, twice `length_scale` for a prismatic one.
        """
        return self._joints.random(rng, size, self.lower, self.upper, self.length_scale)

    def integrate(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """Q ⊕ dq on the manifold: (..., nq) and (..., n) → (..., nq), leading axes broadcast."""
        q, dq = self._checked(q), as_array(dq, "dq", (self.n,))
        check_leading_axes("q", q.shape[:-1], "dq", dq.shape[:-1])
        return self._joints.integrate(q, dq)

    def difference(self, q_from: ArrayLike, q_to: ArrayLike) -> Array:
        """The dq with q_from ⊕ dq = q_to, (..., n); the short way round for continuous joints."""
        q_from, q_to = self._checked(q_from), self._checked(q_to)
        check_leading_axes("q_from", q_from.shape[:-1], "q_to", q_to.shape[:-1])
        return self._joints.difference(q_from, q_to)

    def _checked(self, q: ArrayLike) -> Array:
        return self._joints.checked(q, self.name)

    # -------------------------------------------------------------------------------------------------------- frames
    @property
    def model(self) -> Model:
        """The Pinocchio model, with a joint of its own for each mimic joint. It must not be changed."""
        return self._pinocchio.model

    def create_data(self) -> Data:
        """New working memory for `model`, for direct calls of Pinocchio."""
        return self.model.createData()

    def pinocchio_q(self, q: ArrayLike) -> Array:
        """Pinocchio's configuration (model.nq,), mimic joints included, of one configuration (nq,)."""
        return self._joints.all_joints(alone(self._checked(q), "q", 1)).copy()

    @property
    def mixing(self) -> Array:
        """Velocities of the N joints of `model`, mimic joints included, are `mixing` @ q̇, (N, n)."""
        return self._joints.mixing

    @property
    def frames(self) -> tuple[str, ...]:
        """Every frame name: links and joints."""
        return tuple(self._pinocchio.frames)

    def chain(self, frame: str | None = None) -> Chain:
        """The joints that move a frame, as constants for compiled code.

        Args:
            frame: Link or joint; default the tip.
        """
        return self._pinocchio.chain(self._frame_index(frame))

    def pose(self, q: ArrayLike, frame: str | None = None) -> Array:
        """The pose of a frame in the world.

        Args:
            q: Configurations, (..., nq).
            frame: Link or joint; default the tip.

        Returns:
            Homogeneous transforms, (..., 4, 4).
        """
        q = self._checked(q)
        if q.ndim == 1:
            return self._pinocchio.pose(q, self._frame_index(frame))
        return self.chain(frame).poses(q)

    def jacobian(
        self,
        q: ArrayLike,
        frame: str | None = None,
        reference: Reference = "local_world_aligned",
        *,
        rows: Sequence[str] | None = None,
    ) -> Array:
        """The geometric Jacobian of a frame: twist = J q̇.

        Args:
            q: Configurations, (..., nq).
            frame: Link or joint; default the tip.
            reference: "local_world_aligned" (the frame's point, world axes), "local" (the frame's point and
                axes) or "world" (the world's origin and axes).
            rows: Task rows, of x y z wx wy wz; default `self.rows`.

        Returns:
            (..., len(rows), n), rows linear then angular, in m and rad per rad or m.
        """
        q = self._checked(q)
        if q.ndim == 1:
            return self._select(self._pinocchio.jacobian(q, self._frame_index(frame), reference), rows, axis=-2)
        return self._select(self.chain(frame).jacobians(q, reference), rows, axis=-2)

    def hessian(
        self,
        q: ArrayLike,
        frame: str | None = None,
        reference: Reference = "local_world_aligned",
        *,
        rows: Sequence[str] | None = None,
    ) -> Array:
        """The derivative of the Jacobian: [i, j, k] = ∂J_ij/∂q_k.

        Args:
            q: Configurations, (..., nq).
            frame: As for `jacobian`.
            reference: As for `jacobian`.
            rows: As for `jacobian`.

        Returns:
            (..., len(rows), n, n).
        """
        q = self._checked(q)
        if q.ndim == 1:
            return self._select(self._pinocchio.hessian(q, self._frame_index(frame), reference), rows, axis=-3)
        return self._select(self.chain(frame).hessians(q, reference), rows, axis=-3)

    def singular_value_gradients(
        self, q: ArrayLike, frame: str | None = None, *, rows: Sequence[str] | None = None
    ) -> Array:
        """∂σᵢ/∂q_k of the Jacobian, world axes at the frame's point, without its Hessian.

        It equals `robust_ik.singular_value_gradients` of `jacobian` and `hessian`; see there for σ = 0 and for equal
        singular values.

        Args:
            q: Configurations, (..., nq).
            frame: As for `jacobian`.
            rows: As for `jacobian`.

        Returns:
            (..., k, n) with k = min(len(rows), n); row i belongs to σᵢ.
        """
        q, names = self._checked(q), self.rows if rows is None else checked_rows(rows)
        gradients = self.chain(frame).singular_value_gradients(q.reshape(-1, self.nq), names)
        return gradients.reshape(*q.shape[:-1], *gradients.shape[1:])

    def _select(self, array: Array, rows: Sequence[str] | None, axis: int) -> Array:
        names = self.rows if rows is None else checked_rows(rows)
        if names == ROWS:
            return array
        return np.take(array, [ROWS.index(name) for name in names], axis=axis)

    def _frame_index(self, name: str | None) -> int:
        name = self.tip if name is None else name
        if name is None:
            raise TipError(
                f"{self.name} was loaded whole, without a tip: name a frame; its leaves are "
                + listed(self.description.leaves)
            )
        return self._pinocchio.index(name, self.name, self.description)

    # -------------------------------------------------------------------------------------------- inverse kinematics
    @cached_property
    def size(self) -> float:
        """The distance that the links from the first axis to the tip span, m; 0 if no joint moves the tip's point.

        Slides are taken as close to zero as their limits allow; their travel counts only if the links are short of a
        metre, that of mobile bases never. For a whole tree it is the size of the limb with the longest offsets.
        """
        held = [self.description.joint[name].part_of != "" for name in self.joint_names]
        return find_size(self._longest_chain, np.where(held, 0.0, self.lower), np.where(held, 0.0, self.upper))

    @cached_property
    def length_scale(self) -> float:
        """The length that stands for one metre in comparisons of lengths with angles or tolerances, m per rad.

        It is 1 m for robots of 0.2 to 10 m, else the power of two closest to their `size`. So a robot behaves alike in
        any unit of length.
        """
        return 1.0 if is_usual(self._longest_chain) else unit_of(self.size)

    @cached_property
    def _longest_chain(self) -> Chain:
        if self.tip is not None:
            return self.chain()
        return max(map(self.chain, self.description.leaves), key=lambda chain: float(offsets_of(chain)[1:].sum()))

    @cached_property
    def _pose_solvers(self) -> dict[tuple[str | None, tuple[str, ...]], PoseSolver]:
        return {}

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

    def way_out(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        threshold: float = SINGULAR,
    ) -> WayOut:
        """Whether and how a commanded motion can be followed from q, also where first order says that it is lost.

        Args:
            q: Configuration, (nq,).
            twist: The command in the rows, (m,), m/s and rad/s at the frame's point in world axes; its length does not
                matter.
            frame: Link or joint; default the tip.
            rows: Task rows; default `self.rows`.
            threshold: σ/σ₁ up to which a direction counts as lost, above 0 and below 1.

        Returns:
            A verdict (fold, both ways, turn first, end of reach, structural, free) with the joint motion.
        """
        checked_parameter("threshold", threshold, above=0, below=1)
        names = self.rows if rows is None else checked_rows(rows)
        q, twist = self._checked(q), as_measures(twist, "twist", (len(names),))
        if q.ndim != 1 or twist.ndim != 1:
            raise InputError(f"one q and one twist are needed, got shapes {q.shape} and {twist.shape}")
        return way_out(self, q, twist, frame, names, threshold)

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
