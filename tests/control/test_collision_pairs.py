"""What is remembered of pairs of solids saves work and changes no result."""

import copy

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.control.limits import CollisionLimit, Obstacle, placed_pairs
from robust_ik.description.joint_tree import Sphere
from tests.control.test_collision import around, at, joint, link, robot_of

TREES = {
    "panda, fingers that slide": ("panda", {"whole_tree": True}),
    "kinova, joints without ends": ("kinova", {}),
    "talos arm": ("talos_arm", {}),
    "pr2, sliding and following joints": ("pr2", {"whole_tree": True}),
}


def far_out():
    """A cart on a rail of 3 m on a turntable: what turns is as long as the cart is out."""
    return robot_of(
        link("base"), joint("base", "plate"), link("plate"), joint("plate", "cart", "prismatic", axis="1 0 0"),
        link("cart", x=0.2),
    )  # fmt: skip


@pytest.fixture(scope="module", params=[*TREES, "a long rail"])
def watched(request):
    name, how = TREES.get(request.param, ("", {}))
    robot = rik.load(name, **how) if name else far_out()
    return robot, CollisionLimit.of(robot, obstacles=around())


def walk(robot, rng, count):
    """Configurations along a motion with pauses, turns back, long strides and jumps."""
    q, q_before, direction = robot.rest, robot.rest, rng.normal(size=robot.n)
    for _ in range(count):
        kind = rng.integers(12)
        if kind == 0:
            q_next, direction = robot.random(rng), rng.normal(size=robot.n)
        elif kind == 1:
            q_next = q_before
        elif kind == 2:
            q_next = robot.integrate(q, 0.3 * rng.normal(size=robot.n))
        else:
            q_next = robot.integrate(q, 0.02 * direction)
        q_before, q = q, q_next
        yield q


def test_contacts_along_a_motion_are_those_of_a_scene_that_remembers_nothing(watched, rng):
    robot, limit = watched
    found = 0
    for q in walk(robot, rng, 60):
        within = float(rng.choice([0.02, 0.1, 0.1, 0.3]))
        ours = limit._scene.contacts(robot, q, within)
        fresh = copy.deepcopy(limit._scene).contacts(robot, q, within)
        assert [pair for pair, _ in ours] == [pair for pair, _ in fresh]
        for (_, mine), (_, other) in zip(ours, fresh):
            assert_array_equal(mine.distance, other.distance)
            assert_array_equal(mine.normal, other.normal)
        found += len(ours)
    assert found > 30


def test_distances_change_by_no_more_than_what_joints_can_move(watched, rng):
    robot, limit = watched
    scene = limit._scene
    for _ in range(15):
        q = robot.random(rng)
        here = copy.deepcopy(scene).at(robot, q)
        here.contacts()
        change = rng.normal(size=robot.n) * (rng.random(robot.n) < 0.3) * rng.choice([0.01, 0.3])
        there = placed_pairs.PlacedPairs(here._pairs, here._motion, robot, robot.integrate(q, change), here)
        least = there.least.copy()
        assert (least < here.least + 1e-12).all()
        for pair, contact in there.contacts():
            assert contact.distance >= least[pair] - 1e-7


@pytest.fixture
def asked(monkeypatch):
    """How often coal is asked."""
    count = []
    ask = placed_pairs.near_contact
    monkeypatch.setattr(placed_pairs, "near_contact", lambda *given: count.append(1) or ask(*given))
    return count


def test_nothing_is_asked_twice_at_one_configuration(asked):
    robot = rik.load("ur5")
    limit = CollisionLimit.of(robot, obstacles=around())
    first = limit.distances(robot, robot.rest)
    done = len(asked)
    assert done >= len(limit.pairs)
    assert [each.distance for each in limit.distances(robot, robot.rest)] == [each.distance for each in first]
    limit.bounds(robot, robot.rest, np.zeros(robot.n), 0.01)
    assert len(asked) == done


def test_pairs_that_cannot_come_near_are_not_asked_for_again(asked):
    robot = rik.load("ur5")
    pairs = [(link, "ball") for link in ("forearm_link", "wrist_2_link", "wrist_3_link")]
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("ball", Sphere(0.1), at(0.0, 0.0, 2.0))], pairs=pairs)
    nearest = limit.distances(robot, robot.rest)[0].distance
    asked.clear()
    steps = int((nearest - limit.influence) / (2.0 * 0.001 * robot.n))
    q = robot.rest
    for _ in range(steps):
        q = robot.integrate(q, np.full(robot.n, 0.001))
        limit.bounds(robot, q, np.zeros(robot.n), 0.01)
    assert steps > 3
    assert not asked


def test_a_limit_used_with_another_robot_of_the_same_joints_forgets_the_first(rng):
    robot = rik.load("ur5")
    other = robot.with_rows(("x", "y", "z"))
    limit = CollisionLimit.of(robot, obstacles=around())
    for q in robot.random(rng, 5):
        assert_allclose(
            limit.bounds(robot, q, np.zeros(6), 0.01).floor, limit.bounds(other, q, np.zeros(6), 0.01).floor
        )
        assert limit._scene.at(other, q) is limit._scene.at(other, q)
        assert limit._scene.at(other, q) is not limit._scene.at(robot, q)
