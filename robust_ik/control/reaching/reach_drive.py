"""The state of a `Reach` in one run: what it does at each step, and when it changes that."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.limits import Limit
from robust_ik.control.reaching.braking import braking_ratio
from robust_ik.control.reaching.goals import GoalFinder
from robust_ik.control.reaching.path import Caps, Path, fitting_speed
from robust_ik.control.reaching.plan import Plan, plan, what_turns
from robust_ik.control.reaching.progress_watch import Noise, Servo, scaled
from robust_ik.control.reaching.search_space import Space
from robust_ik.control.tasks.base import Drive, Moment, Task
from robust_ik.control.tasks.frame import FrameTask
from robust_ik.control.tasks.posture import joint_equation
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import length, singular_values
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot

ARRIVED, NOISY = 1e-6, 3.0
"""Error within which a target is reached: m, or rad times a length; or as a multiple of the error that noise makes."""
LEAVES = 10.0
"""Factor on that error beyond which a reached target counts as left again. Chosen: less would flicker."""
MOST_NOISE = 1e-4
"""Largest noise, rad or m: configurations known worse than this are not noisy but wrong."""
PATIENCE = 1.5, 3.0
"""Patience with a servo: factors on the time that joints need, and on the time that its velocity asks for."""
ALL_BUT = 0.01
"""If a target is out of reach, the servo may miss it by this fraction more than the closest pose."""
NO_NEARER = 1e-3
"""If a target is out of reach, the servo must gain this fraction of its distance in a window to go on."""
CAME_BACK = 0.5
"""Fraction of the distance of a target out of reach below which it has come back."""
PIECES = 20
"""Pieces of a search in one step. Chosen: more find a solution in fewer steps, each of which takes longer."""
FEEDBACK, MOST_FEEDBACK = 5.0, 0.3
"""Gain that keeps joints on their path, 1/s, and largest gain times dt."""
ASIDE, FAR_ASIDE = 0.02, 0.1
"""Distance from its path, rad or m, at which an arm begins to wait for itself, and at which it stops."""
SAME = 0.3
"""Largest motion, rad or m, for which solutions of a target that has moved are the same branch."""
AT_REST = 1e-6
"""Largest speed of a joint at rest, rad/s or m/s. Chosen: far below any motion, far above rounding."""
FAILED, BLOCKED = 4, 1.0
"""Failed paths after which a target is given up, and seconds without progress after which a path is given up."""
MOVED = 0.01
"""Motion of a target, m, or rad times a length, after which it is tried again."""
FIRST_BREAK, LONGEST_BREAK = 0.5, 4.0
"""Seconds after a path during which no other begins if the target moves; doubled if paths follow each other soon."""
REGULAR = 0.02
"""σ_k/σ₁ above which the servo holds a target that was reached by a path."""


class Told:
    """The text that a `Reach` shows as its state."""

    def __init__(self) -> None:
        self.text = "not begun"


@dataclass(frozen=True, eq=False)
class Now:
    """The inputs of one step.

    Attributes:
        task: The task.
        q: Configuration, (nq,).
        servo: The equation of the straight servo.
        moment: Bounds and previous velocities of the controller.
        hessian: Whether Hessians are needed.
    """

    task: FrameTask
    q: Array
    servo: TaskEquation
    moment: Moment
    hessian: bool


class ReachDrive(Drive):
    """Servoes, plans, follows a path, or holds: a method for each returns an equation, or changes to another method."""

    def __init__(self, robot: Robot, limits: Sequence[Limit], task: FrameTask) -> None:
        """A run that begins with the servo."""
        self.robot = robot
        self._kind = type(task)
        self._same = task.frame, task.rows, task.reference
        self.space = Space.of(robot, task.frame, limits)
        self.caps = Caps.of(task, self.space)
        self.finder = GoalFinder(self.space)
        self.finder.near(task, robot.rest)  # raises for robots with too many joints
        self.noise, self.watch = Noise(robot), Servo(robot, self._start_time())
        self._looks_ahead = self.space.hurried and min(task.max_linear, task.max_angular) < math.inf
        self.time, self.text, self._dt = 0.0, "servoing", 0.01
        self._target: Array | None = None
        self._arrived = False
        self._failures, self._failed_at = 0, task.target
        self._missed = self._was_missed = math.inf
        self._follows = self._holds = self._fails = False
        self._break, self._begin_after, self._ended = FIRST_BREAK, 0.0, -math.inf
        self._search: Generator[None, None, Plan] | None = None
        self._point = self._goal = np.zeros(robot.n)
        self._act: Callable[[Now], TaskEquation | None] = self._servo

    def _start_time(self) -> float:
        moving = self.space.joints
        return min(1.0, float((self.space.speed[moving] / self.space.acceleration[moving]).max()))

    def continues(self, task: Task) -> bool:
        """See `Drive.continues`."""
        return type(task) is self._kind and (task.frame, task.rows, task.reference) == self._same

    def equation(self, task: Any, q: Array, moment: Moment, *, hessian: bool) -> TaskEquation:
        """See `Drive.equation`."""
        now = Now(task, q, task.equation(self.robot, q, hessian=hessian), moment, hessian)
        self.noise.add(q, moment.previous, moment.dt)
        self._dt = moment.dt
        self._moves = self._target is not None and not np.array_equal(task.target, self._target)
        self._target, self.caps = task.target, Caps.of(task, self.space)
        equation = None
        while equation is None:
            equation = self._act(now)
        self.time += moment.dt
        task.tell(self.text)
        return equation

    def share(self, q: Array, qdot: Array) -> float:
        """The share that caps on the tool's speed allow, now and while it brakes; see `Drive.share`."""
        if not self._looks_ahead:
            return min(1.0, float(self.caps.share(self._jacobian(q) @ qdot)))
        return 1.0 / max(1.0, braking_ratio(self.space, self.caps, q, qdot, self._dt))

    # -------------------------------------------------------------------------------------------- servoing
    def _servo(self, now: Now) -> TaskEquation | None:
        self.watch.add(now.q, now.servo, now.moment.dt)
        near = max(ARRIVED, NOISY * min(self.noise.size, MOST_NOISE) * self._turning(now))
        self._arrived = self.watch.error <= near * (LEAVES if self._arrived else 1.0)
        self.text = "arrived" if self._arrived else "servoing"
        if self._arrived:
            self._failures = 0
            self.watch.restart()
        elif self.watch.due:
            if self.time >= self._begin_after and self._stalls(now):
                if self._is_closest(now):
                    self._was_missed, self._holds, self._fails = self.watch.error, False, False
                    self.watch.restart()
                    self._act = self._servo_from_afar
                else:
                    self._begin_planning()
                return None
            self.watch.restart()
        return now.servo

    def _servo_from_afar(self, now: Now) -> TaskEquation | None:
        """The servo to a target out of reach, if it leads as close as the closest pose does; there it holds."""
        self.watch.add(now.q, now.servo, now.moment.dt)
        self._follows = self._follows or self._moves
        if self._follows and self.watch.error < CAME_BACK * self._missed:
            self._back_to_servo()
            return None
        if self.watch.due:
            led_on = not self._follows and self.watch.error <= (1 + ALL_BUT) * self._missed
            failed, self._fails = self._fails, not led_on and not self._is_closest(now)
            if self._fails and (failed or self._follows):  # an arm that was still moving may swing back by itself
                self._back_to_servo()
                return None
            gained, self._was_missed = self._was_missed - self.watch.error, self.watch.error
            if not self._follows and not self._holds and gained <= NO_NEARER * self._missed:
                self._goal, self._holds = self.space.values(now.q), True
            self._follows = False
            self.watch.restart()
        self._holds = self._holds and not self._moves
        self.text = f"out of reach by {in_words(missing(now.servo))}: waiting there"
        return self._towards(now, self._goal) if self._holds else now.servo

    def _is_closest(self, now: Now) -> bool:
        """Whether the target is out of reach and the arm, up to a negligible part, as close to it as possible."""
        if self.finder.near(now.task, now.q).solved:
            return False
        self._missed = self.finder.missed(self.finder.closest(now.task, now.q))
        return self.watch.error <= (1 + ALL_BUT) * self._missed

    def _turning(self, now: Now) -> float:
        units = scaled(now.servo, self.robot)
        return length((units[:, None] * now.servo.J).ravel())

    def _stalls(self, now: Now) -> bool:
        """Whether the servo takes too long for the remaining distance, or does not get there at all."""
        found = self.finder.near(now.task, now.q)
        missed = self.finder.missed(found)
        left = self.watch.error - missed
        if left <= ALL_BUT * missed:
            return True
        x = self.space.values(now.q)
        goal = self.space.nearest_turn(x, found.q[None])[0]
        joints = Path(self.space, np.stack([x, goal]), self.caps).duration
        asked = self.watch.error / max(self.watch.asked, 1e-300)
        return left > self.watch.rate * (PATIENCE[0] * joints + PATIENCE[1] * asked)

    # -------------------------------------------------------------------------------------------- planning
    def _begin_planning(self) -> None:
        self._arrived, self._search = False, None
        self._act = self._hold_to_plan

    def _hold_to_plan(self, now: Now) -> TaskEquation | None:
        self.text = "planning"
        if self._search is None:
            if self.space.hurried and np.abs(now.moment.previous[self.space.joints]).max() > AT_REST:
                return self._braking(now)
            self._point = self.space.values(now.q)
            self._search = plan(self.space, self.finder, now.task, self._point)
        try:
            for _ in range(PIECES):
                next(self._search)
        except StopIteration as done:
            self._search = None
            self._begin_way(now, done.value)
            return None
        return self._towards(now, self._point)

    def _braking(self, now: Now) -> TaskEquation:
        """Brakes all joints in constant ratios, so that the tool goes on along its path, only slower."""
        previous = now.moment.previous
        with np.errstate(divide="ignore"):
            used = self.space.acceleration * now.moment.dt / np.abs(previous)
        slower = max(0.0, 1.0 - float(used[self.space.joints].min()))
        return self._equation(now, slower * previous, np.zeros(self.robot.n))

    def _begin_way(self, now: Now, found: Plan) -> None:
        self._plan = found
        if found.path is None or self._failures >= FAILED:
            self._give_up(now)
            return
        self.path, self._leg, self._s = found.path, 0, 0.0
        self._best, self._best_at = 0.0, self.time
        self._turns = what_turns(found.path)
        self._act = self._go_round

    def _give_up(self, now: Now) -> None:
        self._failed_at = now.task.target
        self._goal, self._act = self.space.values(now.q), self._hold_where_it_is

    # -------------------------------------------------------------------------------------------- going round
    def _go_round(self, now: Now) -> TaskEquation | None:
        self.text = f"going round: {self._turns}"
        if self._moves and not self._follow(now):
            self._leave_way()
            return None
        point = self.path.at(self._leg, self._s)
        aside = self._aside(now, point)
        apart = float(np.abs(aside).max())
        there = SAME if self._moves else max(1e-8, 4 * min(self.noise.size, MOST_NOISE))
        if self._s == 1.0 and self._leg + 1 == self.path.legs and apart <= there:
            self._finish(now)
            return None
        if self._is_blocked():
            self._failures += 1
            self._begin_planning()
            return None
        dt, way = now.moment.dt, self.path.way(self._leg)
        back = self._feedback(dt) * aside
        waits = float(np.clip((FAR_ASIDE - apart) / (FAR_ASIDE - ASIDE), 0.0, 1.0))
        speed = fitting_speed(waits * self.path.speed(self._leg, self._s, dt), way, back, now.moment.bounds)
        wanted = speed * way + back
        share = min(1.0, float(self.caps.share(self._jacobian(now.q) @ wanted)))
        self._advance(share * speed * dt)
        return self._equation(now, share * wanted, aside)

    def _follow(self, now: Now) -> bool:
        """Moves the end of the path to where the target has gone; False if that is another branch."""
        found = self.finder.near(now.task, self.robot.configuration(self.path.goal))
        goal = self.space.nearest_turn(self.path.goal, found.q[None])[0]
        if found.solved != self._plan.reaches or np.abs(goal - self.path.goal).max() > SAME:
            return False
        self.path = self.path.to(goal)
        self._plan = Plan(self.path, (0.0, 0.0) if found.solved else found.error)
        return True

    def _advance(self, step: float) -> None:
        self._s = min(1.0, self._s + step)
        if self._s > 1.0 - 1e-9:
            self._s = 1.0
        if self._s == 1.0 and self._leg + 1 < self.path.legs:
            self._leg, self._s = self._leg + 1, 0.0
        if self._leg + self._s > self._best + 1e-3 or self._s == 1.0:
            self._best, self._best_at = self._leg + self._s, self.time

    def _is_blocked(self) -> bool:
        return self.time - self._best_at > BLOCKED + self.watch.window

    def _finish(self, now: Now) -> None:
        self._goal = self.path.goal
        if not self._plan.reaches:
            self._pause()
            self._act = self._wait_there
        elif not self._moves and self._has_to_be_held(now):
            self._act = self._hold
        else:
            self._arrived = not self._moves
            self._leave_way()

    def _leave_way(self) -> None:
        self._pause()
        self._back_to_servo()

    def _pause(self) -> None:
        """Delays the next path: if the target moves, paths must not follow each other at once."""
        if self.time - self._ended > 2 * LONGEST_BREAK:
            self._break = FIRST_BREAK
        self._begin_after = self.time + self._break if self._moves else self.time
        self._break = min(2 * self._break, LONGEST_BREAK)
        self._ended = self.time

    def _has_to_be_held(self, now: Now) -> bool:
        """Whether to hold joints, not to servo: none is free for lower levels, or the servo would be singular."""
        s = singular_values(now.servo.J)
        return len(now.servo.xdot) >= len(self.space.joints) or s[-1] < REGULAR * s[0]

    def _back_to_servo(self) -> None:
        self.watch.restart()
        self._act = self._servo

    # -------------------------------------------------------------------------------------------- holding
    def _hold(self, now: Now) -> TaskEquation | None:
        self.text = "arrived"
        if self._moves:
            self._back_to_servo()
            return None
        return self._towards(now, self._goal)

    def _wait_there(self, now: Now) -> TaskEquation | None:
        if self._moves:
            self.path = Path(self.space, self._goal[None], self.caps)
            if not self._follow(now):
                self._leave_way()
                return None
            self._goal = self.path.goal
        self.text = f"out of reach by {in_words(self._plan.error)}: waiting there"
        return self._towards(now, self._goal)

    def _hold_where_it_is(self, now: Now) -> TaskEquation | None:
        self.text = "no way there is free: waiting" if self._plan.reaches else "out of reach: waiting"
        moved = self._moves and self._apart(now.task.target, self._failed_at) > MOVED
        if moved:
            self._failures = 0
            self._back_to_servo()
            return None
        return self._towards(now, self._goal)

    def _apart(self, a: Array, b: Array) -> float:
        return length(a[:3, 3] - b[:3, 3]) + self.robot.length_scale * length((a - b)[:3, :3].ravel())

    # -------------------------------------------------------------------------------------------- equations
    def _towards(self, now: Now, point: Array) -> TaskEquation:
        """The equation that leads joints to values nearby, and holds them there."""
        aside = self._aside(now, point)
        back = self._feedback(now.moment.dt) * aside
        share = min(1.0, float(self.caps.share(self._jacobian(now.q) @ back)))
        share *= fitting_speed(1.0, share * back, np.zeros(self.robot.n), now.moment.bounds)
        return self._equation(now, min(share, 1.0) * back, aside)

    def _aside(self, now: Now, point: Array) -> Array:
        """Differences from the joints to their wanted values, (n,); zero for joints that do not move the frame."""
        aside = np.zeros(self.robot.n)
        joints = self.space.joints
        aside[joints] = self.robot.difference(now.q, self.robot.configuration(point))[joints]
        return aside

    def _equation(self, now: Now, wanted: Array, aside: Array) -> TaskEquation:
        joints = self.space.joints
        return joint_equation(
            self.robot, joints, wanted[joints], aside[joints], hessian=now.hessian, weight=now.task.weight
        )

    def _jacobian(self, q: Array) -> Array:
        return self.robot.jacobian(q, self.space.frame, rows=ROWS)

    @staticmethod
    def _feedback(dt: float) -> float:
        return min(FEEDBACK, MOST_FEEDBACK / dt)


def missing(equation: TaskEquation) -> tuple[float, float]:
    """Distance, m, and angle, rad, of a frame from its target."""
    lengths = np.zeros(len(equation.xdot), dtype=bool) if equation.lengths is None else equation.lengths
    return length(equation.error[lengths]), length(equation.error[~lengths])


def in_words(error: tuple[float, float]) -> str:
    """A remaining distance and angle as text."""
    far, turned = error
    words = [f"{1000 * far:.3g} mm"] if far > 1e-7 else []
    if turned > 1e-7:
        words.append(f"{math.degrees(turned):.2g}°")
    return " and ".join(words) or "nothing"
