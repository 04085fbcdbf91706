"""Reaching a pose whatever stands in the straight way, in closed loop."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.reaching.braking import braked
from robust_ik.control.reaching.goals import GoalFinder
from robust_ik.control.reaching.path import Caps, Path, fitting_speed
from robust_ik.control.reaching.search_space import Space
from robust_ik.control.tasks.target_paths import pose
from robust_ik.simulation.scenarios import stretch, with_reach
from tests.conftest import moved_start

ARMS = ("xarm7", "panda", "ur5", "z1", "kinova")
CAPS = {"gain": 5.0, "max_linear": 0.2, "max_angular": 0.8}
DT = 0.02


class Run:
    """A closed loop with one `Reach`, watched; it ends where the arm rests."""

    def __init__(
        self, robot, q0, target, limits=None, dt=DT, seconds=30.0, noise=0.0, alpha=1.0, task=None, inverse=None, **caps
    ):
        self.robot, self.caps = robot, CAPS | caps
        controller, rng = rik.VelocityController(robot, inverse, limits), np.random.default_rng(5)
        reach = rik.Reach(target, **self.caps) if task is None else task
        q, velocity, self.states, self.straight = moved_start(robot, q0), np.zeros(robot.n), [], 0.0
        self.reached, self.qdot, self.over, self.q = np.inf, [], [], [q]
        for step in range(int(seconds / dt)):
            seen = robot.integrate(q, rng.normal(0.0, noise, robot.n)) if noise else q
            qdot = controller.step(seen, reach, dt).qdot
            self.straight += dt * (reach.state == "servoing")
            self.states += [reach.state] if [reach.state] != self.states[-1:] else []
            self.over.append(self._over(seen, qdot))
            velocity = velocity + alpha * (qdot - velocity)
            q = robot.integrate(q, dt * velocity)
            self.qdot.append(qdot)
            self.q.append(q)
            self.error = float(np.linalg.norm(rik.pose_error(robot.pose(q), target)))
            self.reached = min(self.reached, (step + 1) * dt) if self.error < 1e-6 else np.inf
            rests = not noise and np.abs(self.qdot[-10:]).max() < 1e-7
            if rests and (reach.state == "arrived" or reach.state.endswith(("waiting", "there"))):
                break
        self.end, self.reach = q, reach

    def _over(self, q, qdot):
        """By how much the step is beyond speed limits and caps, and its end beyond joint limits."""
        twist, values = (
            self.robot.jacobian(q, rows=tuple("xyz") + ("wx", "wy", "wz")) @ qdot,
            self.robot.joint_values(q),
        )
        return max(
            np.linalg.norm(twist[:3]) - self.caps["gain"] * self.caps["max_linear"],
            np.linalg.norm(twist[3:]) - self.caps["gain"] * self.caps["max_angular"],
            (np.abs(qdot) - self.robot.velocity_limit).max(),
            (values - self.robot.upper).max(),
            (self.robot.lower - values).max(),
        )

    @property
    def least(self):
        """The time that a straight way through joint space takes from the start, within limits and caps."""
        target, space = self.reach.target, Space.of(self.robot, None, [rik.JointLimits.of(self.robot)])
        goals, start = GoalFinder(space).all(self.reach, space.values(self.q[0])), space.values(self.q[0])
        caps = Caps.of(rik.FrameTask(target, **self.caps), space)
        return min(Path(space, np.stack([start, goal]), caps).duration for goal in goals.points)


def pairs(robot, number, seed=11):
    """Starts and targets anywhere within the limits."""
    rng = np.random.default_rng(seed)
    return [(robot.random(rng), robot.pose(robot.random(rng))) for _ in range(number)]


def nearest(limit, robot, run):
    """The least distance of a run."""
    return min(limit.distances(robot, q)[0].distance for q in run.q[::3])


@pytest.mark.parametrize("name", ARMS)
def test_what_can_be_reached_is_within_all_limits_and_in_time(name):
    robot = rik.load(name)
    for q0, target in pairs(robot, 4):
        run = Run(robot, q0, target)
        assert run.reach.state == "arrived"
        assert run.error < 1e-6
        assert max(run.over) <= 1e-9
        assert run.reached <= 2 * run.least + run.straight + 0.5


def test_the_plain_servo_does_not_get_where_reach_does():
    robot = rik.load("z1")
    missed = 0
    for q0, target in pairs(robot, 8):
        straight = rik.simulate(robot, None, rik.FrameTask(target, **CAPS), q0, duration=8, dt=DT)
        missed += np.linalg.norm(straight.final_error) > 1e-2
    assert missed >= 1


@pytest.mark.parametrize("name", ["panda", "kinova"])
def test_with_acceleration_limits_it_arrives_and_keeps_them(name):
    robot = rik.load(name)
    for q0, target in pairs(robot, 2):
        run = Run(robot, q0, target, [rik.JointLimits.of(robot, acceleration=6.0)])
        assert run.reach.state == "arrived"
        assert run.error < 1e-6
        assert max(run.over) <= 1e-9
        assert np.abs(np.diff(run.qdot, axis=0, prepend=0)).max() <= 6.0 * DT + 1e-9


@pytest.mark.parametrize("name", ["xarm7", "panda", "ur10", "puma560", "pa10"])
def test_caps_hold_within_acceleration_limits_however_stiff_the_inverse(name):
    robot = rik.load(name)
    limits = [rik.JointLimits.of(robot, acceleration=5.0)]
    for q0, target in pairs(robot, 3, seed=15):
        run = Run(robot, q0, target, limits, seconds=6.0, inverse=rik.JParse(0.01), max_linear=0.05, max_angular=0.2)
        assert max(run.over) <= 1e-3  # from one sample of a braking to the next


@pytest.mark.parametrize("kind", ["a joint outside", "some joints without", "at once to the ends"])
def test_caps_hold_within_acceleration_limits_of_any_kind(kind):
    robot, rng = rik.load("panda"), np.random.default_rng(0)
    acceleration, gain = np.full(robot.n, 5.0), np.inf if kind == "at once to the ends" else 20.0
    if kind == "some joints without":
        acceleration[1::2] = np.inf
    limits = [rik.JointLimits.of(robot, acceleration=acceleration, gain=gain)]
    for _ in range(4):
        q0, target = robot.random(rng), robot.pose(robot.random(rng))
        if kind == "a joint outside":
            q0[6] = robot.upper[6] + 0.15
        run = Run(robot, q0, target, limits, seconds=2.0, max_linear=0.05, max_angular=0.2)
        speeds = [np.linalg.norm((robot.jacobian(q) @ qdot)[:3]) for q, qdot in zip(run.q, run.qdot)]
        assert max(speeds) <= 0.25 * 1.002


def test_a_braking_is_finite_where_a_joint_rests_at_its_end():
    robot = rik.load("panda")
    limits = rik.JointLimits.of(robot, acceleration=2.0, gain=np.inf)
    space, qdot = Space.of(robot, None, [limits]), np.full(robot.n, 0.5)
    q, qdot[6] = robot.rest.copy(), 0.0
    q[6] = robot.lower[6]
    for each in braked(space, q, qdot, 0.01):
        assert np.isfinite(each).all()


def test_a_braking_keeps_limits_and_is_as_the_controller_brakes(rng):
    """All joints together, but for those that must stop earlier: step by step within the bounds of acceleration."""
    robot, dt = rik.load("panda"), 0.002
    limits = rik.JointLimits.of(robot, acceleration=5.0)
    space = Space.of(robot, None, [limits])
    for _ in range(20):
        q, qdot = robot.random(rng), rng.uniform(-1, 1, robot.n) * robot.velocity_limit
        qdot = np.clip(qdot, *limits.bounds(robot, q, qdot, dt).unhurried)  # what can still be stopped
        gone, speeds = braked(space, q, qdot, dt)
        assert_allclose(gone[0], 0, atol=1e-12)
        assert_allclose(speeds[0], qdot, atol=1e-12)
        assert ((q + gone <= robot.upper + 1e-9) & (q + gone >= robot.lower - 1e-9)).all()
        assert (np.abs(speeds) <= np.abs(qdot) + 1e-12).all()
        now, before, ways, velocities = q, qdot, [0 * q], [qdot]
        while np.abs(before).max() > 1e-3 and len(ways) < 2000:
            now = now + dt * before
            bounds = limits.bounds(robot, now, before, dt)
            left = max(0.0, 1 - 5.0 * dt / np.abs(before).max())
            before = np.clip(left * before, bounds.lower, bounds.upper)
            ways.append(now - q)
            velocities.append(before)
        for place, velocity in zip(gone, speeds):
            apart = np.abs(np.array(ways) - place).max(axis=1)
            assert apart.min() < 0.015
            assert np.abs(velocities[int(apart.argmin())] - velocity).max() < 0.2


def everyday():
    """A Panda at rest, whose hand is to go back and down, towards its base."""
    robot = rik.load("panda")
    target = robot.pose(robot.rest)
    target[[0, 2], 3] -= 0.45, 0.1
    return robot, target


def test_a_hand_goes_back_towards_its_base():
    robot, target = everyday()
    around = rik.CollisionLimit.of(robot)
    run = Run(robot, robot.rest, target, [rik.JointLimits.of(robot), around], dt=0.01, seconds=12)
    assert run.reach.state == "arrived"
    assert run.error < 1e-6
    assert max(run.over) <= 1e-9
    assert nearest(around, robot, run) >= 0.02 - 1e-9


def walled(depth=0.6):
    """A Panda at a table with a wall across it, a configuration on each side, and the limits."""
    robot = rik.load("panda")
    table = rik.Obstacle("table", rik.HalfSpace((0, 0, 1), 0.0))
    wall = rik.Obstacle("wall", rik.Box((depth, 0.02, 0.7)), pose((0.55, 0.0, 0.35), (0, 0, 0)))
    left, right = ([side * 0.9, 0.3, 0, -2.0, 0, 2.3, 0.785] for side in (1, -1))
    return robot, robot.configuration(left), robot.configuration(right), [table, wall]


def test_it_goes_over_a_wall_that_the_servo_rests_at():
    robot, left, right, obstacles = walled()
    around = rik.CollisionLimit.of(robot, obstacles=obstacles)
    run = Run(robot, left, robot.pose(right), [rik.JointLimits.of(robot), around])
    assert any(state.startswith("going round: ") for state in run.states)
    assert run.reach.state == "arrived"
    assert run.error < 1e-6
    assert max(run.over) <= 1e-9
    assert nearest(around, robot, run) >= 0.02 - 1e-9


def test_where_no_way_is_free_it_says_so_and_rests():
    robot, left, right, obstacles = walled()
    target = robot.pose(right)
    inside = rik.Obstacle("block", rik.Box((0.2, 0.2, 0.2)), target)
    around = rik.CollisionLimit.of(robot, obstacles=[*obstacles, inside])
    run = Run(robot, left, target, [rik.JointLimits.of(robot), around])
    assert run.reach.state == "no way there is free: waiting"
    assert np.abs(run.qdot[-5:]).max() < 1e-6
    assert nearest(around, robot, run) >= 0.02 - 1e-9


@pytest.mark.parametrize("name", ARMS)
def test_out_of_reach_it_rests_at_the_closest_pose(name):
    robot = rik.load(name)
    q0, target = pairs(robot, 1, seed=2)[0]
    target[:3, 3] *= 1.5 * robot.size / np.linalg.norm(target[:3, 3])
    run = Run(robot, q0, target)
    closest = np.hypot(*robot.solve_pose(target, effort="thorough").error)
    assert run.error <= 1.01 * closest
    assert run.reach.state.startswith("out of reach by ")
    assert run.reach.state.endswith(": waiting there")
    assert np.abs(run.qdot[-5:]).max() < 1e-6
    assert max(run.over) <= 1e-9


@pytest.mark.parametrize("name", ["xarm7", "ur5"])
@pytest.mark.parametrize("far", [False, True], ids=["reachable", "out of reach"])
def test_noise_and_lag_leave_it_calm(name, far):
    robot, noise, dt = rik.load(name), 1e-4, 0.01
    q0, target = pairs(robot, 1, seed=4)[0]
    if far:
        target[:3, 3] *= 1.5 * robot.size / np.linalg.norm(target[:3, 3])
    run = Run(robot, q0, target, dt=dt, seconds=14, noise=noise, alpha=0.5)
    last = np.abs(run.qdot[-50:])
    assert last.max() < 20 * max(CAPS["gain"], 0.3) * noise * np.sqrt(robot.n)
    assert ("out of reach" in run.reach.state) == far
    assert sum(state.startswith("going round") for state in run.states) <= 2
    if not far:
        assert run.error < 20 * noise
        assert run.reach.state == "arrived"


def test_targets_that_move_are_followed_without_hunting():
    robot = rik.load("ur5")
    start = robot.pose(robot.configuration([0.2, -1.3, 1.6, -1.0, 1.2, 0.0]))
    reaches = []

    def motion(time):
        target = start.copy()
        target[:3, 3] += 0.1 * np.array([np.cos(time) - 1, np.sin(time), 0.0])
        reaches.append(rik.Reach(target, **CAPS))
        return [[reaches[-1]]]

    run = rik.simulate(robot, None, motion, robot.solve_pose(start, robot.rest).q, duration=7, dt=DT)
    assert {reach.state for reach in reaches[:-1]} <= {"arrived", "servoing"}
    assert run.position_error.max() < 0.1 / CAPS["gain"] * 1.2


def test_ways_follow_each_other_slowly_where_a_target_moves_out_of_its_branch():
    robot, began = rik.load("z1"), []
    start, controller, q, last = robot.pose(robot.rest), rik.VelocityController(robot), robot.rest, ""
    for step in range(700):  # round and round the base, whose joint has ends
        target = pose((0.0, 0.0, 0.0), (0.0, 0.0, step * DT)) @ start
        reach = rik.Reach(target, **CAPS)
        q = robot.integrate(q, DT * controller.step(q, reach, DT).qdot)
        if reach.state.startswith("going round") and not last.startswith("going round"):
            began.append(step * DT)
        last = reach.state
    assert 1 <= len(began) <= 6, began
    assert np.diff(began).min(initial=1.0) > 0.5


def test_a_tool_that_is_round_may_end_turned_about_its_axis(rng):
    robot = rik.load("ur5")
    rows = {"rows": ("x", "y", "z", "wx", "wy"), "reference": "target"}
    q0, target = pairs(robot, 1, seed=8)[0]
    task = rik.Reach(target, **CAPS, **rows)
    run = Run(robot, q0, target, task=task)
    assert run.reach.state == "arrived"
    there = robot.pose(run.end)
    assert_allclose(there[:3, 3], target[:3, 3], atol=1e-6)
    assert_allclose(there[:3, 2], target[:3, 2], atol=1e-6)


def test_all_goals_solve_the_target_within_limits_in_any_axes(rng):
    for name in ("ur5", "kinova"):
        robot = rik.load(name)
        target = robot.pose(robot.random(rng))
        task = rik.Reach(target, rows=("x", "y", "z", "wx", "wy"), reference="target")
        space = Space.of(robot, None, [rik.JointLimits.of(robot, margin=0.1)])
        goals = GoalFinder(space).all(task, space.values(robot.rest))
        assert goals.error == (0.0, 0.0)
        assert len(goals.points) > 2
        assert (goals.points >= space.lower).all()
        assert (goals.points <= space.upper).all()
        for goal in goals.points:
            assert_allclose(task.equation(robot, robot.configuration(goal)).error, 0, atol=1e-6)


def test_a_way_is_no_faster_than_limits_and_caps_anywhere(rng):
    robot = rik.load("panda")
    space = Space.of(robot, None, [rik.JointLimits.of(robot, acceleration=4.0)])
    task = rik.FrameTask(np.eye(4), gain=2.0, max_linear=0.1, max_angular=0.3)
    path = Path(space, robot.random(rng, 3), Caps.of(task, space))
    leg, s, speed, time, dt = 0, 0.0, 0.0, 0.0, 0.005
    while (leg, s) != (1, 1.0):
        wanted, way = path.speed(leg, s, dt), path.way(leg)
        most = speed + dt * (4.0 / np.abs(way)).min()
        assert wanted >= speed - dt * (4.0 / np.abs(way)).min() - 1e-9
        speed = min(wanted, most)
        twist = robot.jacobian(path.at(leg, s)) @ (speed * way)
        assert np.linalg.norm(twist[:3]) <= 0.2 + 1e-9
        assert np.linalg.norm(twist[3:]) <= 0.6 + 1e-9
        assert (np.abs(speed * way) <= robot.velocity_limit + 1e-9).all()
        s, time = min(1.0, s + speed * dt), time + dt
        if s > 1 - 1e-9:
            leg, s, speed = (leg, 1.0, speed) if leg == 1 else (1, 0.0, 0.0)
    assert 0.95 * path.duration <= time <= 1.1 * path.duration + 0.1


def test_a_speed_beyond_all_squares_has_its_share():
    space = Space.of(rik.load("ur5"), None, ())
    caps = Caps.of(rik.FrameTask(space.robot.pose(space.robot.rest), gain=1.0, max_linear=0.2, max_angular=1.0), space)
    twists = np.array([[0.1, 0, 0, 0, 0, 0], [3e200, 4e200, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1e-300], [0] * 6])
    assert_allclose(caps.share(twists), [2.0, 0.2 / 5e200, 1e300, np.inf], rtol=1e-12)


def test_a_speed_is_fitted_into_bounds(rng):
    for _ in range(50):
        way, aside = rng.normal(size=(2, 4))
        box = Bounds.free(4)
        bounds = Bounds(
            -rng.uniform(0, 2, 4), rng.uniform(0, 2, 4), box.lower_cause, box.upper_cause, rng.normal(size=(2, 4)),
            -rng.uniform(0, 2, 2), ("a", "b"),
        )  # fmt: skip
        tries = [s for s in np.linspace(0, 3, 301) if bounds.contains(s * way + 0.1 * aside)]
        found = fitting_speed(1.0, way, 0.1 * aside, bounds)
        if tries:
            assert bounds.contains(found * way + 0.1 * aside)
            assert abs(found - 1) <= min(abs(s - 1) for s in tries) + 1e-9


def test_without_a_controller_it_is_a_frame_task(rng):
    robot = rik.load("panda")
    target = robot.pose(robot.random(rng))
    reach, plain = rik.Reach(target, **CAPS), rik.FrameTask(target, **CAPS)
    assert reach.state == "not begun"
    ours, theirs = reach.equation(robot, robot.rest), plain.equation(robot, robot.rest)
    assert_allclose(ours.J, theirs.J)
    assert_allclose(ours.xdot, theirs.xdot)


def test_reset_begins_anew_and_copies_begin_on_their_own():
    robot = rik.load("z1")
    q0, target = pairs(robot, 1)[0]
    reach = rik.Reach(target, **CAPS)
    runs = []
    controller = rik.VelocityController(robot)
    for _ in range(2):
        controller.reset()
        q, states = q0, []
        for _ in range(150):
            q = robot.integrate(q, DT * controller.step(q, reach, DT).qdot)
            states.append(reach.state)
        runs.append((q, states))
    assert runs[0][1] == runs[1][1]
    assert_allclose(runs[0][0], runs[1][0], rtol=0, atol=0)
    assert pickle.loads(pickle.dumps(rik.Reach(target))).state == "not begun"


def test_a_task_that_was_left_out_for_a_step_begins_anew():
    robot = rik.load("z1")
    q, target = pairs(robot, 1)[0]
    reach, controller = rik.Reach(target, **CAPS), rik.VelocityController(robot)
    for _ in range(300):
        q = robot.integrate(q, DT * controller.step(q, reach, DT).qdot)
        if reach.state.startswith("going round"):
            break
    assert reach.state.startswith("going round")
    controller.step(q, rik.DampingTask(), DT)
    controller.step(q, reach, DT)
    assert reach.state == "servoing"


def test_simulation_and_comparison_take_it():
    robot = rik.load("z1")
    q0, target = pairs(robot, 1)[0]
    stack = [[rik.Reach(target, **CAPS)], [rik.PostureTask(robot.rest)]]
    methods = {"J-PARSE": rik.JParse(), "damped": rik.DampedLeastSquares()}
    scenario = rik.Scenario("reach", robot, q0, stack, 8.0, dt=DT, methods=methods)
    runs = rik.compare(scenario)["reach"]
    for run in runs.values():
        assert np.linalg.norm(run.final_error) < 1e-4
        assert_allclose(run.target[0], target)


def test_a_path_is_followed_with_it():
    robot = rik.load("ur5")
    start = robot.pose(robot.configuration([0.2, -1.3, 1.6, -1.0, 1.2, 0.0]))
    follow = rik.Follow(rik.Line(start, start[:3, 3] + [0.0, 0.1, 0.0], 0.05), task=rik.Reach, feedforward=True, **CAPS)
    assert isinstance(follow(0.0)[0][0], rik.Reach)
    run = rik.simulate(robot, None, follow, robot.solve_pose(start, robot.rest).q, duration=2.5, dt=DT)
    assert run.position_error.max() < 2e-3
    for wrong in (rik.PositionTask, rik.Reach(start), "Reach"):
        with pytest.raises(rik.InputError, match="task must be FrameTask or Reach"):
            rik.Follow(lambda time: start, task=wrong)


def test_levels_below_have_what_it_leaves_once_it_has_arrived():
    robot = rik.load("panda")
    stack = [[rik.Reach(robot.pose(robot.rest), **CAPS)], [rik.JointTask("panda_joint3", 0.3, gain=2.0)]]
    run = rik.simulate(robot, None, stack, robot.rest, duration=3, dt=DT)
    assert stack[0][0].state == "arrived"
    assert np.linalg.norm(run.final_error) < 1e-3
    assert_allclose(run.final_q[2], 0.3, atol=1e-2)


@pytest.mark.parametrize(
    "given, words",
    [
        ({"target": np.ones((4, 4))}, "target must be rigid"),
        ({"gain": 0.0}, "gain must be > 0"),
        ({"max_linear": -1.0}, "max_linear must be > 0"),
        ({"rows": ("q",)}, "rows"),
        ({"reference": "tool"}, "reference must be"),
        ({"frame": 3}, "frame must be the name"),
        ({"weight": 0}, "weight must be > 0"),
    ],
)
def test_what_cannot_be_meant_is_refused(given, words):
    with pytest.raises(rik.InputError, match=words):
        rik.Reach(**{"target": np.eye(4)} | given)


def test_a_frame_that_is_not_there_is_told_by_name():
    robot = rik.load("z1")
    with pytest.raises(rik.FrameNotFoundError, match="hand"):
        rik.VelocityController(robot).step(robot.rest, rik.Reach(np.eye(4), frame="hand"), DT)


def test_a_frame_that_no_joint_moves_is_left_alone():
    robot = rik.load("panda", whole_tree=True)
    step = rik.VelocityController(robot).step(robot.rest, rik.Reach(np.eye(4), frame="panda_link0"), DT)
    assert not step.qdot.any()


@pytest.mark.parametrize("name", ["xarm7", "puma560"])
def test_out_of_reach_it_does_not_swing_about_where_straight_on_is_as_good(name):
    """The demo: the target leaves the arm's reach, waits, and comes back."""
    scenario = with_reach(stretch(rik.load(name)))
    motion = rik.Follow(scenario.path, gain=5.0, max_linear=scenario.max_linear, max_angular=0.5, task=rik.Reach)
    robot, q = scenario.robot, scenario.q0
    controller, went = rik.VelocityController(robot, limits=scenario.limits), []
    for time in np.arange(0.0, scenario.path.duration, scenario.dt):
        stack = motion(time)
        q = robot.integrate(q, scenario.dt * controller.step(q, stack, scenario.dt).qdot)
        beyond = not robot.solve_pose(stack[0][0].target, q).solved if round(time, 2) % 0.5 == 0 else False
        went.append((stack[0][0].state, beyond))
    states = [state for state, beyond in went if beyond]
    assert len(states) > 5
    assert not any(state.startswith(("planning", "going round")) for state in states)
    assert any(state.startswith("out of reach by ") for state in states)
    assert np.linalg.norm(robot.pose(q)[:3, 3] - scenario.path(scenario.path.duration)[:3, 3]) < 1e-3
