"""Robots from a micrometre to a hundred kilometres do what they do at a metre."""

import pickle
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.scaled_levels import Units
from robust_ik.control.tasks import Task
from robust_ik.description.urdf.urdf_reader import parse_urdf
from robust_ik.inverses.task_equation import TaskEquation
from tests.arms import arm_of
from tests.arms import ur5 as made_ur5

SIZES = (2.0**-20, 1e-6, 1e-3, 1.0, 1e3, 1e5)
SLIDE = ("0 0 0.2", "0 0 0", "0 0 1", 0.1, 0.9, "slide")
SCARA = [
    ("0 0 0.3", "0 0 0", "0 0 1", -2.5, 2.5),
    ("0.4 0 0", "0 0 0", "0 0 1", -2.5, 2.5),
    ("0.3 0 0", "0 0 0", "0 0 1", -2.5, 2.5),
    ("0 0 0.1", "0 0 0", "0 0 1", -0.3, 0.1, "slide"),
]
WRIST = [("0 0 1", "0 0 0", "0 0 1", -2, 2), ("0 0 0", "0 0 0", "0 1 0", -2, 2), ("0 0 0", "0 0 0", "1 0 0", -2, 2)]


@cache
def ur5(size=1.0):
    return made_ur5(size)


def start_and_target(robot):
    q = np.array([0.3, -1.2, 1.4, -0.9, 1.1, 0.2])
    return q, robot.pose(q + np.array([0.3, -0.2, 0.25, 0.2, -0.3, 0.4]))


# ------------------------------------------------------------------------------------------------------------- sizes
def test_a_robot_of_usual_size_is_measured_in_metres():
    assert {rik.load(name).length_scale for name in ("panda", "ur5", "puma560", "planar_3r", "so101", "kinova")} == {
        1.0
    }


@pytest.mark.parametrize("size", SIZES)
def test_the_length_scale_goes_by_the_size(size):
    robot = ur5(size)
    assert_allclose(robot.size, size * ur5().size, rtol=1e-6)
    assert robot.length_scale == 1.0 or 0.7 < robot.length_scale / robot.size < 1.42


def test_a_robot_of_another_size_is_noted():
    assert not ur5().notes
    assert "its links span 0.00095 m" in ur5(1e-3).notes[-1]


def test_the_size_of_an_arm_is_the_sum_of_its_links():
    assert_allclose(rik.load("planar_2r").size, 2.0, rtol=1e-6)
    assert_allclose(arm_of(SCARA, "0 0 0").size, 0.7 + 0.3, atol=0.3)


def test_a_joint_that_follows_with_nothing_has_no_travel():
    """A mimic joint of multiplier 0 stays where it is, however far its source may go."""
    link = '<link name="{}"/>'.format
    joint = (
        '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="0 0 {}"/><axis xyz="{}"/>'
        '<limit lower="0" upper="1" velocity="1" effort="1"/>{}</joint>'.format
    )
    mimic = '<mimic joint="turn" multiplier="0"/>'
    parts = [
        joint("turn", "continuous", "a", "b", 0, "0 0 1", ""),
        joint("lean", "revolute", "b", "c", 0.3, "1 0 0", ""),
    ]
    parts.append(joint("slide", "prismatic", "c", "d", 0.2, "0 0 1", mimic))
    text = f'<robot name="r">{"".join(map(link, "abcd"))}{"".join(parts)}</robot>'
    assert_allclose(rik.Robot.from_description(parse_urdf(text.encode()), "d").size, 0.2)


def test_one_joint_has_a_size_and_a_wrist_has_none():
    assert_allclose(arm_of([("0 0 9", "0 0 0", "0 0 1", -1, 1)], "0.002 0 0").size, 0.002, rtol=1e-6)
    wrist = arm_of(WRIST, "0 0 0")
    assert (wrist.size, wrist.length_scale) == (0.0, 1.0)
    assert arm_of(WRIST, "0.00001 0 0").length_scale == 1.0  # the lengths of a wrist, rounded


def test_the_travel_of_slides_counts_where_there_is_no_arm():
    slides = [("0 0 0", "0 0 0", axis, 0.0, 0.004, "slide") for axis in ("1 0 0", "0 1 0", "0 0 1")]
    assert_allclose(arm_of(slides, "0 0 0").size, 0.012)
    rail = [("0 0 0", "0 0 0", "1 0 0", -1e3, 1e3, "slide"), *SCARA]
    assert arm_of(rail, "0 0 0").length_scale == 1.0


def test_a_whole_tree_is_as_large_as_its_longest_limb():
    assert 0.2 < rik.load("a1", whole_tree=True).size < 0.5


# -------------------------------------------------------------------------------------------------------------- poses
@pytest.mark.parametrize("size", SIZES)
def test_solved_means_within_a_share_of_the_size_and_nothing_is_missed(size, rng):
    robot = ur5(size)
    T = robot.pose(rng.uniform(-3, 3, (100, 6)))
    found = robot.solve_poses(T)
    assert found.solved.all()
    assert np.linalg.norm(robot.pose(found.q)[:, :3, 3] - T[:, :3, 3], axis=1).max() <= 1.5e-8 * robot.size
    assert_array_equal(robot.solve_pose(T[3]).q, found.q[3])


@pytest.mark.parametrize("power", [-20, -5, 12])
@pytest.mark.parametrize("joints", [None, [SLIDE, *SCARA[:3], *WRIST]])
def test_lengths_times_a_power_of_two_change_no_bit_of_the_search(power, joints, rng):
    size = 2.0**power
    one, other = (ur5(s) if joints is None else arm_of(joints, "0 0 0.1", s) for s in (1.0, size))
    units = np.where(one.sliding, size, 1.0)
    solver = rik.PoseSolver(other.chain(), other.lower, other.upper, other.rest, other.rows, size)
    q0, far = one.random(rng, 60), np.diag([1.0, 1, 1, 1])
    far[:3, 3] = 9.0, 9.0, 9.0
    T = np.concatenate([one.pose(one.random(rng, 59)), far[None]])
    scaled = T * np.array([[1, 1, 1, size]] * 3 + [[1, 1, 1, 1]])
    a, b = one.solve_poses(T, q0), solver.solve_many(scaled, q0 * units)
    assert_array_equal(a.q * units, b.q)
    assert_array_equal(a.error * (size, 1), b.error)
    assert_array_equal(a.status, b.status)
    single = solver.solve(scaled[0], q0[0] * units, solutions=3)
    assert_array_equal(single.q, one.solve_pose(T[0], q0[0], solutions=3).q * units)


def test_tolerances_and_weights_are_given_in_metres(rng):
    robot = ur5(1e-3)
    T = robot.pose(rng.uniform(-3, 3, (20, 6)))
    loose = robot.solve_poses(T, position_tolerance=1e-5, rotation_tolerance=1e-2)
    assert loose.solved.all()
    assert loose.error[:, 0].max() <= 1e-5
    assert loose.error[:, 0].max() > 1e-9
    away = T[:1] + np.array([[[0, 0, 0, 0.01]], [[0, 0, 0, 0]], [[0, 0, 0, 0]], [[0, 0, 0, 0]]]).reshape(1, 4, 4)
    light, heavy = (robot.solve_poses(away, length_scale=L).error[0] for L in (1e-5, 1e-1))
    assert light[0] < heavy[0]
    assert light[1] > heavy[1]


def test_what_is_too_far_is_said_in_metres():
    robot, far = ur5(1e-6), np.eye(4)
    far[0, 3] = 1e6
    with pytest.raises(rik.InputError, match="target must lie within 953"):
        robot.solve_pose(far)
    with pytest.raises(rik.InputError, match="targets must lie within 953"):
        robot.solve_poses(far[None])


def test_a_solver_in_other_units_is_pickled(rng):
    solver = ur5(1e-3).pose_solver()
    T = ur5(1e-3).pose(rng.uniform(-3, 3, 6))
    assert_array_equal(pickle.loads(pickle.dumps(solver)).solve(T).q, solver.solve(T).q)


# ------------------------------------------------------------------------------------------------------- closed loops
@pytest.mark.parametrize("inverse", [rik.JParse(), rik.DampedLeastSquares()], ids=["J-PARSE", "DLS"])
@pytest.mark.parametrize("size", SIZES)
def test_a_closed_loop_reaches_its_target_at_every_size(size, inverse):
    robot = ur5(size)
    q, target = start_and_target(robot)
    run = rik.simulate(robot, inverse, [[rik.FrameTask(target, gain=4.0)]], q, duration=4.0, dt=0.05)
    assert np.linalg.norm(run.final_error[:3]) < 1e-3 * robot.size
    assert np.linalg.norm(run.final_error[3:]) < 1e-3
    assert rik.Status.STUCK not in run.status


@pytest.mark.parametrize(
    "resolver", [rik.TaskPriority(), rik.TaskPriority(limiter=rik.QuadraticProgram())], ids=["scaling", "QP"]
)
def test_levels_limits_and_slides_scale_with_the_arm(resolver):
    size, joints = 2.0**-12, [SLIDE, *SCARA]
    q = np.array([0.5, 0.4, 0.7, -0.3, 0.0])
    found = []
    for s in (1.0, size):
        robot = arm_of(joints, "0 0 0", s)
        units = np.where(robot.sliding, s, 1.0)
        target = robot.pose((q + 0.1) * units)
        stack = [[rik.PositionTask(target[:3, 3], gain=3.0)], [rik.PostureTask(q * units)]]
        step = rik.VelocityController(robot, resolver, length_scale=s).step(q * units, stack, 0.01)
        found.append((step.qdot / units, step.residual / s, step.status, step.levels[0].sigma))
    for one, other in zip(*found):
        if isinstance(one, rik.Status):
            assert one is other
        else:
            assert_allclose(one, other, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("joints", [None, [SLIDE, *SCARA[:3], *WRIST]])
def test_a_stepper_gives_the_same_speeds_at_every_size(joints, rng):
    size = 2.0**-10
    one, other = (ur5(s) if joints is None else arm_of(joints, "0 0 0.1", s) for s in (1.0, size))
    units, q, twist = np.where(one.sliding, size, 1.0), one.random(rng), rng.normal(size=6)
    for inverse in (rik.DampedLeastSquares(), rik.JParse(), rik.SDLS()):
        expected = rik.Stepper(one, inverse).step(q, twist) * units
        stepper = rik.Stepper(other, inverse, length_scale=size)
        assert_allclose(stepper.step(q * units, twist * ([size] * 3 + [1] * 3)), expected, rtol=1e-9)
        again = pickle.loads(pickle.dumps(stepper))
        assert again.length_scale == stepper.length_scale == size


def test_whoever_weighs_rows_is_left_alone():
    robot = ur5(1e-3)
    for inverse in (
        rik.Weighted(rik.JParse(), length_scale=1e-3),
        rik.Weighted(rik.JParse(), task_weights=np.ones(6)),
        rik.SDLS(length_scale=1e-3),
    ):
        assert rik.VelocityController(robot, inverse).length_scale == 1.0
        assert rik.Stepper(robot, inverse).length_scale == 1.0
    assert rik.VelocityController(robot, rik.Weighted(rik.JParse(), joint_weights=np.ones(6))).length_scale < 0.01
    assert rik.VelocityController(robot, length_scale=0.5).length_scale == 0.5
    with pytest.raises(rik.InputError, match="length_scale"):
        rik.VelocityController(robot, length_scale=-1.0)


def test_the_singular_value_that_is_climbed_scales():
    climbed = []
    for size in (1.0, 2.0**-10):
        robot = ur5(size)
        equation = rik.SingularValueTask().equation(robot, start_and_target(robot)[0])
        climbed.append(equation.J)
    assert_allclose(*climbed, rtol=1e-8)


@dataclass(frozen=True, eq=False)
class HeightTask(Task):
    height: float

    def equation(self, robot, q, *, hessian=False):
        error = np.array([self.height - robot.pose(q)[2, 3]])
        J = robot.jacobian(q, rows=("z",))
        return TaskEquation(J, 2.0 * error, error, None, self.weight, lengths=np.array([True]))


def test_a_task_of_ones_own_says_which_rows_are_lengths():
    speeds = []
    for size in (1.0, 2.0**-20):
        robot = ur5(size)
        task, controller = HeightTask(0.5 * size), rik.VelocityController(robot, rik.DampedLeastSquares())
        speeds.append(controller.step(start_and_target(robot)[0], task, 0.01).qdot)
    assert_allclose(*speeds, rtol=1e-9)


def test_speed_limits_of_joints_that_slide_are_told_in_the_unit_of_length_too():
    scara = arm_of(SCARA, "0 0 0")
    limits = rik.JointLimits.of(scara, velocity=[1.0, 2.0, 3.0, 0.4])
    bounds = limits.bounds(scara, scara.rest, np.zeros(4), 0.01)
    told = Units(0.1, scara.sliding).problem(VelocityProblem((), bounds)).bounds
    assert_allclose(told.fastest, [1.0, 2.0, 3.0, 4.0])
    assert (np.maximum(told.upper, -told.lower) <= told.fastest + 1e-12).all()
