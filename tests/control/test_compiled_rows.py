"""Where rows of bounds contradict each other or the box, compiled steps are those of NumPy, and say so alike."""

import copy
from dataclasses import dataclass

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits import Limit
from robust_ik.kernels.within_bounds.bounds_layout import UNKNOWNS
from tests import closed_loop
from tests.cases_resolvers import RESOLVERS
from tests.control.test_compiled_steps import DT, LOOSE, assert_same, by_numpy, is_eligible, noise_of, step_of
from tests.soak import collisions_of, random_limits, random_stack, random_start

DRAWS = 60


@dataclass(frozen=True, eq=False)
class Rows(Limit):
    """Rows that stay the same."""

    rows: np.ndarray
    floor: np.ndarray

    def bounds(self, robot, q, previous, dt):
        return Bounds.of_rows(self.rows, self.floor, tuple(f"row {i // 2}" for i in range(len(self.floor))))


def made_by_numpy(controller, monkeypatch):
    """A list that grows by one for each step that NumPy makes."""
    made = []
    monkeypatch.setattr(type(controller), "_within_shares", lambda _, *given: made.append(1) or given[-1])
    return made


def random_rows(n, rng):
    """Rows that ask for more than there is, against each other, or of no joint at all."""
    count = int(rng.integers(1, 24))
    rows = rng.normal(size=(count, n)) * rng.choice([0.01, 1.0, 30.0], size=(count, 1))
    if rng.random() < 0.5:
        rows[:, rng.random(n) < 0.5] = 0.0
    if rng.random() < 0.5 and count > 1:
        rows[1] = -rows[0]
    if rng.random() < 0.3:
        rows[-1] = 0.0
    return rows, rng.normal(size=count) * rng.choice([0.01, 0.3, 5.0])


@pytest.mark.parametrize("name", ["planar_2r", "ur5", "panda", "srs_10r"])
def test_rows_that_cannot_all_be_kept_are_given_up_as_by_numpy(name, monkeypatch):
    robot, rng, yielded = rik.load(name), np.random.default_rng(3), 0
    for draw in range(DRAWS):
        resolver = RESOLVERS[rng.integers(len(RESOLVERS))]
        if not is_eligible(resolver):
            continue
        joints, rows = random_limits(robot, rng), Rows(*random_rows(robot.n, rng))
        limits = [joints, rows] if rng.random() < 0.7 else rows
        q, stack, qdot = random_start(robot, joints, rng), random_stack(robot, rng), 0.1 * rng.normal(size=robot.n)
        scale = rng.choice([None, 0.3])
        numpy = lambda robot: by_numpy(robot, resolver, limits, length_scale=scale)  # noqa: B023, E731
        noise = LOOSE * noise_of(numpy, robot, q, qdot, stack, rng)
        wanted = step_of(numpy, robot, q, qdot, stack)
        controller = rik.VelocityController(robot, resolver, limits, length_scale=scale)
        controller.reset(qdot)
        with monkeypatch.context() as watched:
            made = made_by_numpy(controller, watched)
            found = controller.step(q, stack, DT)
        if made:
            continue
        yielded += any(each.startswith("row ") for each in wanted.contradictions)
        assert_same(found, wanted, noise, f"draw {draw}: {resolver}, {[[*map(type, level)] for level in stack]}")
    assert yielded > 10


@pytest.mark.parametrize("name", ["panda", "ur5", "xarm7"])
def test_arms_that_collide_are_led_out_as_by_numpy(name, monkeypatch):
    robot, rng, led, by_hand = rik.load(name), np.random.default_rng(8), 0, 0
    resolvers = [each for each in RESOLVERS if is_eligible(each)]
    for draw in range(DRAWS // 2):
        resolver, near = resolvers[rng.integers(len(resolvers))], collisions_of(robot, draw % 4, 0.02, 10.0)
        limits = [random_limits(robot, rng), near]
        q, stack, qdot = robot.random(rng), random_stack(robot, rng), 0.1 * rng.normal(size=robot.n)
        numpy = lambda robot: by_numpy(robot, resolver, limits)  # noqa: B023, E731
        noise = LOOSE * noise_of(numpy, robot, q, qdot, stack, rng)
        wanted = step_of(numpy, robot, q, qdot, stack)
        controller = rik.VelocityController(robot, resolver, limits)
        controller.reset(qdot)
        with monkeypatch.context() as watched:
            made = made_by_numpy(controller, watched)
            found = controller.step(q, stack, DT)
        by_hand += bool(made)
        if made:
            continue
        led += near.bounds(robot, q, qdot, DT).floor.max(initial=0) > 0
        assert_same(found, wanted, noise, f"draw {draw}: {resolver}, {[[*map(type, level)] for level in stack]}")
    assert led > 2
    assert by_hand < DRAWS // 6


def test_a_row_that_a_task_moves_above_what_it_reached_is_not_called_active():
    """Its floor has yielded: what counts is where it had come before the levels moved on."""
    robot = rik.load("planar_2r")
    joints = rik.JointLimits.of(robot, velocity=[1.0, 0.0])
    limits = [joints, Rows(np.array([[0.05, 1.0]]), np.array([0.04]))]
    stack = [[rik.JointTask(robot.joint_names[0], robot.rest[0] + 5.0, gain=0.1)]]
    step, wanted = (
        make(robot, None, limits).step(robot.rest, stack, DT) for make in (rik.VelocityController, by_numpy)
    )
    assert_same(step, wanted, 0.0, "")
    assert step.contradictions == ("row 0",)
    assert "row 0" not in step.active


def test_more_rows_than_there_is_room_for_are_left_to_numpy():
    robot = rik.load("planar_3r")
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(UNKNOWNS + 5, robot.n))
    limits = Rows(rows, np.full(len(rows), 3.0))
    stack = [[rik.PostureTask(robot.rest)]]
    step = rik.VelocityController(robot, None, limits).step(robot.rest, stack, DT)
    wanted = by_numpy(robot, None, limits).step(robot.rest, stack, DT)
    np.testing.assert_array_equal(step.qdot, wanted.qdot)
    assert step.status is rik.Status.INFEASIBLE


CORNERED = {
    "ur10": (
        closed_loop.Draw(
            "ur10", "at limits", rik.TaskReconstruction(rik.Chiaverini(), rik.Sliding(), steady=True), True, 0.005,
            False, "collision", 729265618,
        ),
        80,
    ),
    "kinova": (
        closed_loop.Draw(
            "kinova", "anywhere", rik.TaskReconstruction(rik.JParse(0.1), rik.QuadraticProgram(), steady=True), False,
            0.02, False, "collision", 92154741,
        ),
        30,
    ),
}  # fmt: skip
"""Motions that end between an arm's own links, a table and a board, and after how many steps they are there."""


@pytest.mark.parametrize("name", CORNERED)
def test_steps_that_have_to_be_slower_are_those_of_numpy(name, monkeypatch):
    draw, before = CORNERED[name]
    robot, (q, target) = closed_loop.arm(draw.arm), closed_loop.start_and_target(draw.arm, draw.kind, draw.seed)
    limits = closed_loop.limits(draw.arm, draw.surroundings)
    stack = [[rik.FrameTask(target, gain=5.0, max_linear=0.2, max_angular=1.0)], [rik.PostureTask(robot.rest)]]
    controller, numpy = rik.VelocityController(robot, draw.resolver, limits), by_numpy(robot, draw.resolver, limits)
    for _ in range(before):
        q = robot.integrate(q, draw.dt * controller.step(q, stack, draw.dt).qdot)
    controller.reset()
    loop, slower = rik.ControlLoop(controller, stack, draw.dt), []
    slowed = type(controller)._slowed
    monkeypatch.setattr(type(controller), "_slowed", lambda *given: slower.append(given[0]) or slowed(*given))
    for step in range(20):
        found, wanted = controller.step(q, stack, draw.dt), numpy.step(q, stack, draw.dt)
        assert_same(found, wanted, 0.0, f"step {step}")
        np.testing.assert_allclose(loop.step(q), found.qdot, rtol=0, atol=1e-9, err_msg=f"step {step}")
        assert loop.report.contradictions == found.contradictions
        q = robot.integrate(q, draw.dt * wanted.qdot)
    assert slower.count(controller) == slower.count(numpy) == slower.count(loop.controller)
    assert slower


def test_a_step_that_has_to_be_slower_leaves_what_levels_remember_as_numpy_does(monkeypatch):
    """Levels that a limiter stops start slowly again: their last speeds are remembered, that of the slowed step too."""
    dt, seed = 0.02, 459624019
    robot, (start, target) = closed_loop.arm("ur5"), closed_loop.start_and_target("ur5", "at limits", seed)
    resolver = rik.TaskReconstruction(rik.Chiaverini(), rik.Scaling())
    stack = [[rik.FrameTask(target, gain=5.0, max_linear=0.2, max_angular=1.0)], [rik.PostureTask(robot.rest)]]
    limits, slower = closed_loop.limits("ur5", "collision"), []
    slowed = rik.VelocityController._slowed
    monkeypatch.setattr(rik.VelocityController, "_slowed", lambda *given: slower.append(1) or slowed(*given))

    def controller_after(steps):
        controller, q, taken = rik.VelocityController(robot, resolver, limits), start, 0
        while taken < steps and not (slower and steps == MOST):
            q = robot.integrate(q, dt * controller.step(q, stack, dt).qdot)
            taken += 1
        return controller, q, taken

    _, _, first = controller_after(MOST)
    assert slower
    controller, q, _ = controller_after(first - 1)
    numpy = by_numpy(robot, resolver, limits)
    numpy.reset(controller.qdot)
    numpy._driver = copy.deepcopy(controller._driver)
    numpy.calming.memory[:] = controller.calming.memory
    before = [limiter.speed for limiter in controller.begun(dt).eased[:2]]
    slower.clear()
    assert_same(controller.step(q, stack, dt), numpy.step(q, stack, dt), 0.0, "")
    assert len(slower) == 2
    speeds = [[limiter.speed for limiter in each.begun(dt).eased[:2]] for each in (controller, numpy)]
    np.testing.assert_allclose(*speeds, rtol=1e-6, atol=1e-15)
    assert not np.allclose(speeds[1], before, rtol=1e-3, atol=0)


MOST = 400
"""Steps after which the arm stands between its links at the latest."""
