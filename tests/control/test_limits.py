"""Position, velocity and acceleration limits of joints: what they promise about any sequence of steps."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.limits import JointLimits
from robust_ik.control.limits.joint_limits import braking_speed

PLANAR = rik.load("planar_3r")
TIMES = [1e-4, 1e-3, 0.01, 0.1, 1.0]


def limits(**changes):
    given = {"lower": -1.0, "upper": 1.0, "velocity": 2.0, "acceleration": 4.0, "recovery_speed": 0.2} | changes
    return JointLimits.of(PLANAR, **given)


def stopping_distance(speed, acceleration, dt, gain=np.inf):
    """What a joint goes until it stops, step by step; slower than acceleration/gain by the share gain·dt a step."""
    gain = min(gain, 1 / dt)
    distance = 0.0
    while speed > acceleration / gain:
        distance += dt * speed
        speed -= acceleration * dt
    return distance + max(speed, 0.0) / gain


@pytest.mark.parametrize("dt", TIMES)
@pytest.mark.parametrize("gain", [np.inf, 20.0, 1.0])
def test_the_braking_speed_is_the_largest_one_from_which_a_joint_stops_in_time(dt, gain, rng):
    for _ in range(100):
        acceleration = 10 ** rng.uniform(-1, 2)
        room = rng.uniform(0, 300) ** 2 * acceleration * dt * dt * rng.choice([1e-3, 1e-2])
        speed = braking_speed(np.array([room]), np.array([acceleration]), dt, gain)[0]
        assert stopping_distance(speed * (1 - 1e-9), acceleration, dt, gain) <= room * (1 + 1e-9)
        assert stopping_distance(speed * (1 + 1e-6) + 1e-12, acceleration, dt, gain) > room


def test_the_braking_speed_without_room_is_zero_and_without_limits_is_none():
    room, acceleration = np.array([0.0, 0.0, np.inf, 0.3]), np.array([2.0, np.inf, 2.0, np.inf])
    assert_allclose(braking_speed(room, acceleration, 0.1), [0, 0, np.inf, 3])
    assert_allclose(braking_speed(room, acceleration, 0.1, gain=2.0), [0, 0, np.inf, 0.6])


@pytest.mark.parametrize("acceleration", [np.inf, 4.0])
def test_a_joint_that_is_asked_to_its_end_comes_to_rest_there_and_each_step_is_slower(acceleration):
    each, q, previous = limits(acceleration=acceleration), np.zeros(3), np.zeros(3)
    speeds = []
    for _ in range(1000):
        previous = each.bounds(PLANAR, q, previous, 0.005).upper
        q = q + 0.005 * previous
        speeds.append(previous[0])
    braking = np.array(speeds)[np.argmax(speeds) + 400 :]
    assert (np.diff(speeds[-200:]) <= 0).all()
    assert (braking >= 0).all()
    assert_allclose(q, 1, atol=1e-9)
    assert (q <= 1).all()


@pytest.mark.parametrize("dt", TIMES)
@pytest.mark.parametrize("outside", [0.0, 1e-9, 0.01, 1.0])
def test_from_rest_no_sequence_of_steps_needs_more_than_the_acceleration_nor_leaves_the_limits(dt, outside, rng):
    for _ in range(12):
        each = limits(
            lower=-rng.uniform(0.01, 2, 3),
            upper=rng.uniform(0.01, 2, 3),
            velocity=np.where(rng.random(3) < 0.2, np.inf, rng.uniform(0.01, 5, 3)),
            acceleration=np.where(rng.random(3) < 0.2, np.inf, 10 ** rng.uniform(-2, 2, 3)),
            recovery_speed=10 ** rng.uniform(-2, 1),
            gain=rng.choice([1.0, 20.0, np.inf]),
        )
        q, previous = rng.uniform(each.lower, each.upper) + outside * rng.normal(size=3), np.zeros(3)
        for _ in range(60):
            bounds = each.bounds(PLANAR, q, previous, dt)
            assert bounds.contradictions == ()
            assert (bounds.lower <= bounds.upper).all()
            pick = rng.random(3)
            within = rng.uniform(np.maximum(bounds.lower, -99), np.minimum(bounds.upper, 99))
            qdot = np.clip(np.select([pick < 0.4, pick < 0.8], [bounds.lower, bounds.upper], within), -1e4, 1e4)
            assert (np.abs(qdot - previous) <= each.acceleration * dt * (1 + 1e-9) + 1e-12).all()
            assert (np.abs(qdot) <= each.velocity).all()
            was_out, q = np.maximum(np.maximum(q - each.upper, each.lower - q), 0), q + dt * qdot
            assert (np.maximum(q - each.upper, each.lower - q) <= was_out + 1e-12).all()
            previous = qdot


@pytest.mark.parametrize("dt", TIMES)
@pytest.mark.parametrize("acceleration", [np.inf, 0.5])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_joint_that_is_outside_comes_back_monotonically_no_faster_than_asked_and_arrives(dt, acceleration, side):
    each = limits(acceleration=acceleration, gain=np.inf)
    q, previous = np.array([side * 1.3, 0.0, 0.0]), np.zeros(3)
    needed = int(0.3 / (0.2 * dt) + 0.2 / (0.5 * dt)) + 3
    for _ in range(min(needed, 3000)):
        bounds = each.bounds(PLANAR, q, previous, dt)
        least = np.clip(0.0, bounds.lower, bounds.upper)  # what is demanded of a joint that would rather rest
        assert np.abs(least).max() <= 0.2 + 1e-12
        assert (-side * least >= 0)[0]
        q, previous = q + dt * least, least
    if needed <= 3000:
        assert abs(q[0]) <= 1 + 1e-9
    else:
        assert abs(q[0]) < 1.3


def test_a_joint_that_is_hardly_outside_is_asked_to_come_back_only_to_its_end():
    for gain, asked in ((np.inf, -1e-4), (20.0, -2e-5), (2.0, -2e-6)):
        each = limits(acceleration=np.inf, gain=gain)
        bounds = each.bounds(PLANAR, np.array([1 + 1e-6, 0, 0]), np.zeros(3), 0.01)
        assert_allclose(bounds.upper[0], asked, rtol=1e-6)


def test_a_joint_comes_back_no_faster_than_it_can_stop_before_its_other_end():
    each = limits(lower=-1e-3, upper=1e-3, acceleration=0.01, recovery_speed=1.0)
    for hurry in (0.0, 0.5, 1.0):
        q, previous = np.array([0.5, -0.5, 0.0]), np.zeros(3)
        for _ in range(300):
            bounds = each.bounds(PLANAR, q, previous, 0.1)
            assert (bounds.lower <= bounds.upper).all()
            assert bounds.contradictions == ()
            slow = np.clip(0.0, bounds.lower, bounds.upper)
            fast = np.where(q > 0, bounds.lower, bounds.upper)
            previous = slow + hurry * (fast - slow)
            q = q + 0.1 * previous
        assert (np.abs(q) <= 1e-3 + 1e-9).all()


def test_a_joint_that_is_outside_and_goes_further_out_is_stopped_at_once_and_the_acceleration_yields():
    bounds = limits().bounds(PLANAR, np.array([1.1, 0, 0]), np.array([1.0, 0, 0]), 0.01)
    assert bounds.upper[0] <= 0
    assert bounds.contradictions == ("joint1 acceleration",)


@pytest.mark.parametrize("dt", TIMES)
def test_a_joint_too_fast_to_stop_keeps_its_position_limit_and_its_acceleration_yields_by_name(dt):
    start = np.array([1 - 0.5 * dt, 0, -1 + 0.5 * dt])
    each = limits(velocity=1e3)
    bounds = each.bounds(PLANAR, start, np.array([100.0, 0, -100.0]), dt)
    assert bounds.contradictions == ("joint1 acceleration", "joint3 acceleration")
    assert (start + dt * bounds.upper <= 1 + 1e-12).all()
    assert (start + dt * bounds.lower >= -1 - 1e-12).all()
    assert bounds.active(bounds.upper)[0] == "joint1 position"


def test_a_joint_faster_than_its_limit_slows_down_and_its_acceleration_yields():
    bounds = limits().bounds(PLANAR, np.zeros(3), np.array([5.0, 0, 0]), 0.01)
    assert bounds.upper[0] == 2.0
    assert bounds.contradictions == ("joint1 acceleration",)


def test_a_joint_of_speed_zero_never_moves_inside_or_outside():
    each = limits(velocity=[0.0, 1, 1], acceleration=np.inf)
    for angle in (0.0, 1.0, 2.0, -5.0):
        bounds = each.bounds(PLANAR, np.array([angle, 0, 0]), np.zeros(3), 0.1)
        assert bounds.lower[0] == bounds.upper[0] == 0


@pytest.mark.parametrize("acceleration", [np.inf, 100.0])
def test_towards_an_end_a_joint_uses_up_the_share_of_the_way_that_its_gain_says(acceleration):
    q, dt = np.array([1 - 0.01, 0.0, -1 + 0.02]), 0.005
    for gain in (20.0, 5.0):
        bounds = limits(acceleration=acceleration, gain=gain).bounds(PLANAR, q, np.zeros(3), dt).lasting
        assert_allclose([bounds.upper[0], -bounds.lower[2]], [0.01 * gain, 0.02 * gain])
    at_once = limits(acceleration=np.inf, gain=np.inf, velocity=np.inf).bounds(PLANAR, q, np.zeros(3), dt)
    assert_allclose([at_once.upper[0], -at_once.lower[2]], [0.01 / dt, 0.02 / dt])


def test_infinite_limits_are_none():
    each = limits(lower=-np.inf, upper=np.inf, velocity=np.inf, acceleration=np.inf)
    bounds = each.bounds(PLANAR, np.full(3, 1e9), np.full(3, 1e9), 0.01)
    assert np.isneginf(bounds.lower).all()
    assert np.isposinf(bounds.upper).all()
    assert bounds.active(np.full(3, 1e9)) == ()


def test_the_margin_keeps_from_both_ends_and_is_recovered_from():
    each = JointLimits.of(PLANAR, lower=-1, upper=[1, 2, 3], margin=0.25, velocity=9)
    assert_allclose([each.lower, each.upper], [[-0.75] * 3, [0.75, 1.75, 2.75]])
    assert each.bounds(PLANAR, np.array([0.8, 0, 0]), np.zeros(3), 0.01).upper[0] < 0


def test_the_default_is_the_robots_own_limits_and_they_are_copies_that_cannot_be_written_to():
    robot = rik.load("panda")
    each = JointLimits.of(robot)
    assert (each.lower == robot.lower).all()
    assert (each.velocity == robot.velocity_limit).all()
    assert np.isinf(each.acceleration).all()
    given = np.ones(3)
    made = limits(upper=given)
    given[:] = -7
    assert (made.upper == 1).all()
    with pytest.raises(ValueError, match="read-only"):
        made.upper[0] = 3


def test_joints_that_turn_without_end_have_speed_limits_only_unless_others_are_given():
    robot = rik.load("kinova")
    turning = np.isinf(robot.upper)
    assert turning.any()
    q = robot.configuration(np.full(robot.n, 3.1))
    own = JointLimits.of(robot).bounds(robot, q, np.zeros(robot.n), 0.1)
    assert_allclose(own.upper[turning], robot.velocity_limit[turning])
    narrow = JointLimits.of(robot, lower=-1, upper=1, recovery_speed=0.1).bounds(robot, q, np.zeros(robot.n), 0.1)
    assert (narrow.upper < 0).all()


def test_causes_name_the_joint_and_the_kind():
    each = limits(acceleration=100.0)
    bounds = each.bounds(PLANAR, np.array([0.999, 0, 0]), np.zeros(3), 0.1)
    assert bounds.upper_cause.tolist() == ["joint1 position", "joint2 velocity", "joint3 velocity"]
    hurried = limits(acceleration=0.1).bounds(PLANAR, np.zeros(3), np.zeros(3), 0.1)
    assert hurried.lower_cause.tolist() == [f"joint{i} acceleration" for i in (1, 2, 3)]


@pytest.mark.parametrize(
    "changes, match",
    [
        ({"lower": 2.0}, r"lower \+ margin ≤ upper − margin must hold, got 2 and 1 for joint1"),
        ({"margin": 1.5}, r"lower \+ margin ≤ upper − margin must hold, got 0.5 and -0.5 for joint1"),
        ({"upper": -np.inf}, "must hold"),
        ({"lower": np.inf, "upper": np.inf}, "must hold, got inf and inf"),
        ({"lower": np.nan}, "lower must be a number for every joint, infinite for no limit, got"),
        ({"upper": [1, np.nan, 1]}, "upper must be a number"),
        ({"velocity": -1.0}, "velocity must be ≥ 0 for every joint"),
        ({"velocity": np.nan}, "velocity must be ≥ 0"),
        ({"acceleration": 0.0}, "acceleration must be > 0 for every joint"),
        ({"acceleration": 1e-300}, "acceleration must be > 0"),
        ({"acceleration": -1.0}, "acceleration must be > 0"),
        ({"margin": -0.1}, "margin must be ≥ 0"),
        ({"margin": np.nan}, "margin must be ≥ 0"),
        ({"lower": [1, 2]}, r"lower must be one number or 3, one per joint, got \[1, 2\]"),
        ({"velocity": "fast"}, "velocity must be one number or 3, one per joint, got 'fast'"),
        ({"recovery_speed": 0.0}, "recovery_speed must be > 0"),
        ({"gain": 0.0}, "gain must be > 0"),
        ({"gain": np.ones((6, 7))}, "gain must be > 0"),
        ({"gain": np.zeros((3, 0))}, "gain must be > 0"),
        ({"gain": np.zeros(2, dtype=[("a", float)])}, "gain must be > 0"),
        ({"recovery_speed": np.nan}, "recovery_speed must be > 0"),
        ({"gain": np.nan}, "gain must be > 0"),
    ],
)
def test_limits_that_cannot_be_meant_are_refused(changes, match):
    with pytest.raises(rik.InputError, match=match):
        limits(**changes)


def test_the_constructor_checks_as_well():
    good = {
        "lower": np.zeros(2),
        "upper": np.ones(2),
        "velocity": np.ones(2),
        "acceleration": np.ones(2),
        "recovery_speed": 0.1,
        "joint_names": ("a", "b"),
    }
    assert JointLimits(**good).joint_names == ("a", "b")
    for name, value, match in [
        ("upper", -np.ones(2), r"must hold, got 0 and -1 for a"),
        ("velocity", np.array([1, np.nan]), "velocity must be ≥ 0"),
        ("acceleration", np.ones(3), r"acceleration must be one for each of 2 joints, got \(3,\)"),
    ]:
        with pytest.raises(rik.InputError, match=match):
            JointLimits(**good | {name: value})


def test_the_limits_of_another_robot_are_refused_by_the_names_of_its_joints():
    panda = rik.load("panda")
    with pytest.raises(rik.InputError, match="these limits are for joint1, joint2, joint3, panda has panda_joint1"):
        limits().bounds(panda, panda.rest, np.zeros(7), 0.01)
