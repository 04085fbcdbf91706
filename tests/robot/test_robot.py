"""A robot's kinematics over every chain of example-robot-data: against differences and the closed screw form."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.catalog import EXAMPLES, catalog
from robust_ik.description.urdf.urdf_reader import parse_urdf, read_urdf
from tests import pinocchio_reference
from tests.screws import Chain

REFERENCES = ("local", "world", "local_world_aligned")
EXAMPLE_NAMES = [name for name, entry in catalog().items() if entry.source == EXAMPLES]
WITHOUT_JOINTS = {"hector", "iris_simple"}


@cache
def description(name):
    return read_urdf(catalog()[name].path)


def chains(name):
    """A robot per leaf that at least two joints move."""
    tree = description(name)
    return [rik.Robot.from_description(tree, leaf) for leaf in tree.leaves if len(tree.moving_joints(leaf)) >= 2]


def all_values(robot, q):
    """Joint name → value, mimic joints included, straight from the description."""
    values = dict(zip(robot.joint_names, robot.joint_values(q)))

    def value(joint):
        if joint.mimic is None:
            return values.get(joint.name)
        return joint.mimic.multiplier * value(robot.description.joint[joint.mimic.source]) + joint.mimic.offset

    return {joint.name: value(joint) for joint in robot.description.chain(robot.tip) if joint.kind != "fixed"}


def mixing(robot, names):
    """∂(value of each joint of the chain)/∂(independent joints), by differences of an affine map."""
    base = all_values(robot, robot.neutral)
    columns = []
    for unit in np.eye(robot.n):
        moved = all_values(robot, robot.configuration(unit))
        columns.append([moved[name] - base[name] for name in names])
    return np.array(columns).T


@pytest.mark.slow
def test_the_catalogue_has_the_package_and_most_of_it_has_chains():
    assert len(EXAMPLE_NAMES) > 50
    assert {name for name in EXAMPLE_NAMES if not description(name).joints or not chains(name)} <= (
        WITHOUT_JOINTS | {"iris"}
    )


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_pose_jacobian_and_hessian_are_the_closed_screw_form(name, rng):
    for robot in chains(name):
        q = robot.random(rng)
        values = all_values(robot, q)
        chain = Chain.at(robot.description.xml, robot.tip, values)
        M = mixing(robot, chain.names)
        assert_allclose(robot.pose(q), chain.T, atol=1e-9)
        for reference in REFERENCES:
            J, H = robot.jacobian(q, reference=reference), robot.hessian(q, reference=reference)
            assert_allclose(J, chain.jacobian(reference) @ M, atol=1e-9, err_msg=f"{robot} {reference}")
            closed = np.einsum("rik,ia,kb->rab", chain.hessian(reference), M, M)
            assert_allclose(H, closed, atol=1e-9, err_msg=f"{robot} {reference}")


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_batches_equal_pinocchio_one_by_one(name, rng):
    for robot in chains(name):
        q = robot.random(rng, 9)  # more than are done side by side
        assert_allclose(robot.pose(q), [pinocchio_reference.pose(robot, one, robot.tip) for one in q], atol=1e-12)
        for reference in REFERENCES:
            for function in ("jacobian", "hessian"):
                expected = [getattr(pinocchio_reference, function)(robot, one, robot.tip, reference) for one in q]
                found = getattr(robot, function)(q, reference=reference)
                assert_allclose(found, expected, atol=1e-12, err_msg=f"{robot} {function} {reference}")


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_jacobian_and_hessian_agree_with_central_differences(name, rng):
    h = 1e-5
    for robot in chains(name):
        q = robot.random(rng)
        around = robot.integrate(q, h * np.concatenate([np.eye(robot.n), -np.eye(robot.n)]))
        ahead, behind = np.split(robot.pose(around), 2)
        twists = difference_twists(ahead, behind) / (2 * h)
        assert_allclose(robot.jacobian(q), twists.T, atol=1e-6, err_msg=str(robot))
        for reference in REFERENCES:
            J = robot.jacobian(around, reference=reference)
            differences = np.moveaxis(J[: robot.n] - J[robot.n :], 0, -1) / (2 * h)
            H = robot.hessian(q, reference=reference)
            assert_allclose(H, differences, atol=1e-6, err_msg=f"{robot} {reference}")


def difference_twists(ahead, behind):
    """Twists that lead from `behind` to `ahead`, to second order, world axes at the tip."""
    linear = ahead[:, :3, 3] - behind[:, :3, 3]
    turn = ahead[:, :3, :3] @ np.swapaxes(behind[:, :3, :3], -1, -2)
    skew = (turn - np.swapaxes(turn, -1, -2)) / 2
    return np.concatenate([linear, np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)], axis=-1)


@pytest.fixture(params=["panda", "kinova", "tiago"])
def robot(request):
    return rik.load(request.param)


@pytest.mark.parametrize("function", ["pose", "jacobian", "hessian"])
def test_batches_equal_a_loop(robot, function, rng):
    q = robot.random(rng, (2, 3))
    batch = getattr(robot, function)(q)
    loop = np.array([[getattr(robot, function)(one) for one in row] for row in q])
    assert batch.shape == loop.shape
    assert_allclose(batch, loop, atol=1e-12)  # compiled, and Pinocchio


@pytest.mark.parametrize("function", ["pose", "jacobian", "hessian"])
def test_batches_have_the_bits_of_batches_of_one(robot, function, rng):
    q = robot.random(rng, 11)  # eight side by side, and three more
    asked = getattr(robot, function)
    assert (asked(q) == np.concatenate([asked(one[None]) for one in q])).all()


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_a_single_joint_has_matrices_too(kind):
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><link name="tip"/>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        '<joint name="t" type="fixed"><parent link="b"/><child link="tip"/><origin xyz="2 0 0"/></joint></robot>'
    )
    robot = rik.Robot.from_description(parse_urdf(text))
    slides = kind == "prismatic"
    J, H = robot.jacobian(robot.neutral), robot.hessian(robot.neutral)
    assert_allclose(J, np.array([[0, 0, 1, 0, 0, 0] if slides else [0, 2, 0, 0, 0, 1]]).T, atol=1e-15)
    assert_allclose(H, np.array([0, 0, 0, 0, 0, 0] if slides else [-2, 0, 0, 0, 0, 0]).reshape(6, 1, 1), atol=1e-15)
    assert robot.jacobian(np.stack([robot.neutral] * 3)).shape == (3, 6, 1)


def test_an_empty_batch_is_an_empty_result(robot):
    assert robot.jacobian(np.zeros((0, robot.nq))).shape == (0, 6, robot.n)


def test_the_result_depends_on_q_alone_whatever_was_asked_before(robot, rng):
    q, other = robot.random(rng, 2)
    before = robot.jacobian(q), robot.hessian(q), robot.pose(q)
    robot.hessian(other)
    after = robot.jacobian(q), robot.hessian(q), robot.pose(q)
    assert all((a == b).all() for a, b in zip(before, after))


def test_results_are_the_callers_own(robot, rng):
    q = robot.random(rng)
    first = robot.jacobian(q)
    first[:] = 0
    assert robot.jacobian(q).any()


def test_threads_can_share_a_robot(robot, rng):
    q = robot.random(rng, 400)
    for function in (robot.pose, robot.jacobian, robot.hessian):
        expected = [function(one) for one in q]
        with ThreadPoolExecutor(8) as pool:
            shared = list(pool.map(function, q))
            halves = list(pool.map(function, np.split(q, 8)))
        assert (np.array(shared) == expected).all()
        assert (np.concatenate(halves) == function(q)).all()


def test_a_robot_survives_pickling(robot, rng):
    again = pickle.loads(pickle.dumps(robot))
    q = robot.random(rng)
    assert (again.jacobian(q) == robot.jacobian(q)).all()
    assert again.joint_names == robot.joint_names


def test_any_frame_can_be_asked_for(rng):
    robot = rik.load("panda")
    q = robot.random(rng)
    for frame in robot.frames:
        assert_allclose(robot.pose(q, frame)[3], [0, 0, 0, 1])
        assert robot.jacobian(q, frame).shape == (6, 7)
    assert not robot.jacobian(q, "panda_link0").any()


def test_rows_select_from_the_six(rng):
    robot = rik.load("panda")
    q = robot.random(rng, 2)
    full_J, full_H = robot.jacobian(q), robot.hessian(q)
    some = robot.with_rows(("z", "x", "wy"))
    assert (some.jacobian(q) == full_J[:, [2, 0, 4]]).all()
    assert (some.hessian(q) == full_H[:, [2, 0, 4]]).all()
    assert (robot.jacobian(q, rows=("x",)) == full_J[:, [0]]).all()


def test_random_configurations_lie_inside_the_limits_and_fill_them(robot, rng):
    values = robot.joint_values(robot.random(rng, 500))
    bounded = np.isfinite(robot.lower)
    assert (values >= robot.lower).all()
    assert (values <= robot.upper).all()
    spread = np.ptp(values, axis=0)
    assert (spread[bounded] > 0.9 * (robot.upper - robot.lower)[bounded]).all()
    assert (spread[~bounded] > 0.9 * 2 * np.pi).all()


def test_integrate_and_difference_undo_each_other(robot, rng):
    q = robot.random(rng, 20)
    dq = rng.uniform(-1, 1, (20, robot.n))
    moved = robot.integrate(q, dq)
    assert_allclose(robot.difference(q, moved), dq, atol=1e-12)
    assert_allclose(robot.integrate(q, robot.difference(q, moved)), moved, atol=1e-12)


def test_continuous_joints_stay_on_the_circle_over_many_steps():
    robot = rik.load("double_pendulum_continuous")
    q = robot.neutral
    assert robot.nq == 4
    for _ in range(2000):
        q = robot.integrate(q, [0.7, -1.3])
    assert_allclose(np.hypot(q[0::2], q[1::2]), 1, atol=1e-12)
    assert_allclose(q[:2], [np.cos(1400), np.sin(1400)], atol=1e-9)


@pytest.mark.parametrize("bad", [np.zeros(6), np.zeros((2, 8)), 3.0])
def test_a_q_of_the_wrong_shape_is_refused_and_the_joints_are_named(bad):
    with pytest.raises(rik.InputError, match=r"shape \(\.\.\., 7\).*panda_joint1"):
        rik.load("panda").jacobian(bad)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_q_that_is_not_finite_is_refused(value):
    with pytest.raises(rik.InputError, match="finite"):
        rik.load("panda").pose([value, 0, 0, 0, 0, 0, 0])


def test_a_q_that_is_no_number_is_refused():
    with pytest.raises(rik.InputError, match="real numbers"):
        rik.load("panda").pose(["a"] * 7)


def test_cos_and_sin_off_the_circle_are_refused():
    with pytest.raises(rik.InputError, match="joint1"):
        rik.load("double_pendulum_continuous").pose([1, 1, 1, 0])


def test_an_unknown_frame_is_refused_and_names_are_offered():
    with pytest.raises(rik.FrameNotFoundError, match="did you mean 'panda_hand_tcp'"):
        rik.load("panda").pose(np.zeros(7), "panda_hand_tpc")


def test_an_unknown_reference_is_refused():
    with pytest.raises(rik.InputError, match="local_world_aligned"):
        rik.load("panda").jacobian(np.zeros(7), reference="tool")


@pytest.mark.parametrize("rows", [(), ("x", "x"), ("x", "rz"), "xq"])
def test_unknown_rows_are_refused(rows):
    with pytest.raises(rik.InputError, match="x y z wx wy wz"):
        rik.load("panda").with_rows(rows)


@pytest.mark.parametrize("size", [-1, 1.5, "3", (2, -1)])
def test_a_size_that_is_no_count_is_refused(size, rng):
    with pytest.raises(rik.InputError, match="count"):
        rik.load("panda").random(rng, size)
    assert rik.load("panda").random(rng, np.int64(3)).shape == (3, 7)


def test_leading_axes_that_do_not_fit_are_refused(rng):
    robot = rik.load("panda")
    q = robot.random(rng, 3)
    for refused in (
        lambda: robot.integrate(q, np.zeros((2, 7))),
        lambda: robot.difference(q, robot.random(rng, 2)),
        lambda: rik.JParse().solve(robot.jacobian(q), np.zeros((2, 6))),
        lambda: rik.pose_error(robot.pose(q), np.stack([np.eye(4)] * 2)),
        lambda: rik.manipulability_gradient(robot.jacobian(q), np.zeros((2, 6, 7, 7))),
    ):
        with pytest.raises(rik.InputError, match="do not broadcast"):
            refused()


def test_one_sided_limits_leave_a_full_turn(rng):
    table = rik.DHTable(
        [rik.DHJoint(a=1, d=0, alpha=0, lower=5.0), rik.DHJoint(a=1, d=0, alpha=0, upper=-4)], "standard"
    )
    robot = rik.Robot.from_dh(table)
    values = robot.random(rng, 1000)
    assert_allclose(values.min(axis=0), [5, -4 - 2 * np.pi], atol=0.1)
    assert_allclose(values.max(axis=0), [5 + 2 * np.pi, -4], atol=0.1)


def test_a_dh_robot_has_the_limits_of_its_table_not_those_its_urdf_had_to_state():
    robot = rik.load("pa10")
    assert (robot.lower == -np.inf).all()
    assert (robot.upper == np.inf).all()
    assert (robot.velocity_limit == np.inf).all()


@pytest.mark.parametrize(
    "change", [np.asarray, np.asfortranarray, lambda q: q.tolist(), lambda q: q.astype(np.float32)]
)
def test_any_array_of_numbers_will_do(change, rng):
    robot = rik.load("panda")
    q = robot.random(rng, 3).astype(np.float32).astype(float)
    q.setflags(write=False)
    assert_allclose(robot.jacobian(change(q)), robot.jacobian(q), atol=1e-12)


@pytest.mark.parametrize("bad", [np.zeros(7) * 1j, ["0"] * 7, np.zeros(7, "M8[s]"), np.ma.masked_array(np.zeros(7))])
def test_what_is_no_real_number_is_refused(bad):
    with pytest.raises(rik.InputError, match="real numbers"):
        rik.load("panda").pose(bad)


def test_copies_stay_read_only(robot):
    again = pickle.loads(pickle.dumps(robot))
    for array in (again.lower, again.rest, again._joints.mixing):
        assert not array.flags.writeable


def test_joints_that_follow_others_with_factors_and_offsets_equal_pinocchios(rng):
    kinds = [
        ("a", "continuous", ""),
        ("b", "revolute", '<mimic joint="a" multiplier="-0.5" offset="0.3"/>'),
        ("c", "prismatic", ""),
        ("d", "prismatic", '<mimic joint="c" multiplier="2" offset="0.1"/>'),
        ("e", "prismatic", '<mimic joint="a" multiplier="0.1" offset="0.2"/>'),
        ("f", "revolute", ""),
        ("g", "continuous", '<mimic joint="f" multiplier="1" offset="-0.7"/>'),
    ]
    text = '<robot name="r"><link name="l0"/>' + "".join(
        f'<link name="l{i + 1}"/><joint name="{name}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="0.3 0.1 {0.1 * i}" rpy="{0.4 * i} 0.2 -0.3"/><axis xyz="{i % 2} {(i + 1) % 2} 0"/>'
        f'<limit lower="-2" upper="2" velocity="1" effort="1"/>{mimic}</joint>'
        for i, (name, kind, mimic) in enumerate(kinds)
    )
    robot = rik.Robot.from_description(parse_urdf(text + "</robot>"))
    assert robot.n == 3
    q = robot.random(rng, 11)
    expected = [pinocchio_reference.pose(robot, one, robot.tip) for one in q]
    assert_allclose(robot.pose(q), expected, atol=1e-12)
    assert_allclose([robot.pose(one) for one in q], expected, atol=1e-12)
    for reference in REFERENCES:
        for name in ("jacobian", "hessian"):
            function = getattr(robot, name)
            expected = [getattr(pinocchio_reference, name)(robot, one, robot.tip, reference) for one in q]
            assert_allclose(function(q, reference=reference), expected, atol=1e-12)
            assert_allclose([function(one, reference=reference) for one in q], expected, atol=1e-12)
