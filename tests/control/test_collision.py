"""Distances as limits: their derivatives, that they are kept, which pairs count, what is refused."""

import copy
import math
import pickle
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations

import numpy as np
import pytest
import trimesh
from lxml import etree
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.limits import CollisionLimit, HalfSpace, Obstacle, collision_geometry, srdf
from robust_ik.control.limits.collision_geometry import LEAST_THICKNESS, contact, convex_hull, placed, primitive
from robust_ik.control.limits.srdf import find_srdf, read_srdf
from robust_ik.description.catalog import find
from robust_ik.description.joint_tree import Box, Cylinder, Mesh, Sphere
from robust_ik.description.urdf.urdf_reader import parse_urdf
from robust_ik.errors import InputError, LoadError, RobotNotFoundError, UrdfError

ROBOTS = ("panda", "panda_collision", "ur5", "xarm7", "z1", "talos_arm", "kinova", "so101")
DT = 0.01


def at(x, y, z, turn=0.0):
    T = np.eye(4)
    T[:2, :2] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
    T[:3, 3] = x, y, z
    return T


def around():
    return (
        Obstacle("table", HalfSpace((0.0, 0.1, 1.0), -0.3)),
        Obstacle("ball", Sphere(0.1), at(0.5, 0, 0.4)),
        Obstacle("crate", Box((0.2, 0.3, 0.4)), at(-0.4, 0.5, 0.3, 0.7)),
        Obstacle("post", Cylinder(0.05, 1.0), at(0.1, -0.5, 0.3)),
    )


def link(name, shape='<sphere radius="0.05"/>', x=0.0, tag="collision"):
    geometry = f'<{tag}><origin xyz="{x} 0 0"/><geometry>{shape}</geometry></{tag}>' if shape else ""
    return f'<link name="{name}">{geometry}</link>'


def joint(parent, child, kind="revolute", x=0.0, axis="0 0 1", inside=""):
    return (
        f'<joint name="{parent}_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x} 0 0"/><axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="2" effort="1"/>{inside}'
        "</joint>"
    )


def robot_of(*parts, **options):
    return rik.Robot.from_description(parse_urdf(f'<robot name="r">{"".join(parts)}</robot>'), **options)


def planar():
    """Two links of 0.5 m, with a sphere of 0.05 m at the end of the second only."""
    return robot_of(
        link("base", ""),
        link("upper", ""),
        link("lower", x=0.5),
        joint("base", "upper"),
        joint("upper", "lower", x=0.5),
    )


def slider(axis="1 0 0"):
    return robot_of(link("base"), link("cart"), joint("base", "cart", "prismatic", axis=axis))


def respected(bounds, wish):
    """The wish, projected onto one violated row after the other."""
    for _ in range(3000):
        spare = (bounds.rows @ wish - bounds.floor) / np.maximum(np.linalg.norm(bounds.rows, axis=1), 1e-12)
        if not len(spare) or spare.min() > -1e-9:
            return wish
        worst = int(np.argmin(spare))
        row = bounds.rows[worst]
        wish = wish + (bounds.floor[worst] + 1e-9 - row @ wish) / (row @ row) * row
    return np.zeros_like(wish)


def spare(limit, robot, q):
    return limit.distances(robot, q)[0].distance - limit.distance


# ---------------------------------------------------------------------------------------- derivatives
def test_between_spheres_the_row_and_the_floor_are_the_closed_form(rng):
    robot, center = planar(), np.array([0.9, 0.3, 0.0])
    limit = CollisionLimit.of(
        robot, obstacles=[Obstacle("ball", Sphere(0.1), at(*center))], influence=3.0, gain=5.0, distance=0.01
    )
    for q in robot.random(rng, 50):
        tip = np.array(
            [0.5 * math.cos(q[0]) + 0.5 * math.cos(q.sum()), 0.5 * math.sin(q[0]) + 0.5 * math.sin(q.sum()), 0]
        )
        normal = (tip - center) / np.linalg.norm(tip - center)
        d = np.linalg.norm(tip - center) - 0.15
        J = robot.jacobian(q, "lower", rows=("x", "y", "z")) + 0.5 * np.outer(
            [-math.sin(q.sum()), math.cos(q.sum()), 0], [1, 1]
        )
        bounds = limit.bounds(robot, q, np.zeros(2), DT)
        assert_allclose(bounds.rows, [normal @ J], atol=1e-9)
        fastest = min(0.1, np.abs(normal @ J).sum() * 0.5)
        assert_allclose(bounds.floor, [min(-5 * (d - 0.01), fastest)], atol=1e-9)
        (found,) = limit.distances(robot, q)
        assert found.names == ("lower", "ball")
        assert found.distance == pytest.approx(d, abs=1e-9)
        assert_allclose(found.point_a, tip - 0.05 * normal, atol=1e-9)
        assert_allclose(found.point_b, center + 0.1 * normal, atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_rows_are_the_derivatives_of_distances(name, rng):
    robot = rik.load(name)
    limit = CollisionLimit.of(robot, obstacles=around(), distance=0.0, influence=100.0)
    scene, h = limit._scene, 1e-5

    def distances(q):
        contacts = scene.contacts(robot, q)
        return contacts, np.array([there.distance for _, there in contacts])

    checked = kinks = 0
    for q in robot.random(rng, 6):
        contacts, here = distances(q)
        rows = scene.rows(robot, q, contacts)
        for column, step in enumerate(h * np.eye(robot.n)):
            ahead, behind = (distances(robot.integrate(q, sign * step))[1] for sign in (1, -1))
            smooth = np.abs(ahead - 2 * here + behind) < 1e-3 * h
            assert_allclose(rows[smooth, column], ((ahead - behind) / (2 * h))[smooth], atol=1e-3)
            checked, kinks = checked + smooth.sum(), kinks + (~smooth).sum()
    assert checked > 500
    assert kinks < 0.01 * checked


@pytest.mark.parametrize("first", [Box((0.2, 0.3, 0.4)), Sphere(0.15), Cylinder(0.1, 0.4), "hull"])
@pytest.mark.parametrize("second", [Box((0.2, 0.3, 0.4)), Sphere(0.15), Cylinder(0.1, 0.4), "hull", HalfSpace()])
def test_a_contact_is_along_its_normal_and_ends_when_shifted_by_its_depth(first, second, rng):
    a, b = (convex_hull(rng.normal(scale=0.1, size=(30, 3))) if s == "hull" else primitive(s) for s in (first, second))
    for _ in range(40):
        pose, turn = np.eye(4), np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pose[:3, :3] = turn * np.linalg.det(turn)
        pose[:3, 3] = rng.normal(scale=0.2, size=3)
        there = contact(a, placed(pose), b, placed(np.eye(4)))
        assert np.linalg.norm(there.normal) == pytest.approx(1)
        assert_allclose(there.point_b - there.point_a, there.distance * there.normal, atol=2e-3)
        pose[:3, 3] -= (0.01 - there.distance) * there.normal
        assert contact(a, placed(pose), b, placed(np.eye(4))).distance == pytest.approx(0.01, abs=1e-4)


# ---------------------------------------------------------------------------------------- the promise
@pytest.mark.parametrize("name", ROBOTS)
def test_whatever_is_wished_distances_are_kept_up_to_second_order(name, rng):
    robot = rik.load(name)
    limit = CollisionLimit.of(robot, obstacles=around(), gain=1 / DT)
    far_sighted = CollisionLimit.of(robot, obstacles=around(), influence=100.0)
    starts = [q for q in robot.random(rng, 60) if spare(limit, robot, q) > -1e-6]
    touched = 0
    for q in starts[:3]:
        for step in range(90):
            everything = far_sighted.bounds(robot, q, np.zeros(robot.n), DT)
            if step == 0:
                soon = np.argsort(-everything.floor / np.linalg.norm(everything.rows, axis=1))
                nearby = everything.row_cause[soon[rng.integers(5)]]
                stir = 0.1 * rng.normal(size=robot.n)
            wish = stir - everything.rows[everything.row_cause.index(nearby)]
            bounds = limit.bounds(robot, q, np.zeros(robot.n), DT)
            qdot = respected(bounds, 1.5 * wish / np.linalg.norm(wish))
            touched += int((bounds.rows @ qdot - bounds.floor < 1e-6).any())
            q = robot.integrate(q, DT * qdot)
            assert spare(limit, robot, q) > -4 * (1.5 * DT) ** 2
    assert touched > 0


@pytest.mark.parametrize("shape", [Sphere(0.15), Box((0.2, 0.3, 0.4)), Cylinder(0.1, 0.4)])
@pytest.mark.parametrize("name, last", [("xarm7", "link7"), ("ur5", "wrist_3_link"), ("talos_arm", "arm_left_6_link")])
def test_out_of_a_collision_the_way_is_monotonic_and_slow(name, last, shape, rng):
    robot = rik.load(name)
    q = robot.random(rng)
    place = robot.pose(q, last)[:3, 3] + [0.02, 0.01, 0.0]
    limit = CollisionLimit.of(
        robot, obstacles=[Obstacle("o", shape, at(*place))], pairs=[(last, "o")], recovery_speed=0.05
    )
    distance = spare(limit, robot, q)
    assert distance < -0.05
    for _ in range(2000):
        before = distance
        q = robot.integrate(q, DT * respected(limit.bounds(robot, q, np.zeros(robot.n), DT), np.zeros(robot.n)))
        distance = spare(limit, robot, q)
        assert before - 1e-6 < distance < before + 2 * DT * 0.05
        if distance > -1e-4:
            return
    pytest.fail(f"still {-distance} m inside")


def test_spheres_with_one_centre_come_apart():
    robot = slider()
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("o", Sphere(0.1))], pairs=[("cart", "o")])
    q = np.zeros(1)
    for _ in range(400):
        q = robot.integrate(q, DT * respected(limit.bounds(robot, q, np.zeros(1), DT), np.zeros(1)))
    assert spare(limit, robot, q) > -1e-3


@pytest.mark.parametrize("gain", [1.0, 1e9])
def test_a_step_never_uses_up_more_than_what_is_left(gain):
    robot = slider()
    limit = CollisionLimit.of(
        robot, obstacles=[Obstacle("o", Sphere(0.1), at(0.3, 0, 0))], gain=gain, pairs=[("cart", "o")]
    )
    q = np.array([0.1])
    for dt in (1e-3, 0.1, 10.0):
        (row,), (floor,) = (limit.bounds(robot, q, np.zeros(1), dt).rows, limit.bounds(robot, q, np.zeros(1), dt).floor)
        assert row == pytest.approx(-1)
        assert floor == pytest.approx(-min(gain, 1 / dt) * 0.03)


def test_far_pairs_have_no_row_and_near_ones_say_what_they_are():
    robot = slider()
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("table", Sphere(0.1), at(1, 0, 0))])
    assert limit.bounds(robot, np.array([0.5]), np.zeros(1), DT).rows.shape == (0, 1)
    assert limit.bounds(robot, np.array([0.8]), np.zeros(1), DT).row_cause == ("cart - table distance",)


def test_a_pair_that_no_joint_can_part_gives_no_row():
    robot = slider(axis="0 1 0")
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("wall", HalfSpace((1, 0, 0), 0.02))], pairs=[("cart", "wall")])
    assert spare(limit, robot, np.zeros(1)) < 0
    bounds = limit.bounds(robot, np.zeros(1), np.zeros(1), DT)
    assert bounds.rows.shape == (0, 1)
    assert bounds.contains(np.zeros(1))


def test_the_way_out_asks_no_joint_for_more_than_half_its_speed(rng):
    robot = planar()
    for q in robot.random(rng, 30):
        wall = HalfSpace(tuple(rng.normal(size=2)) + (0.0,), 3.0)
        limit = CollisionLimit.of(robot, obstacles=[Obstacle("o", wall)], recovery_speed=1e3, pairs=[("lower", "o")])
        bounds = limit.bounds(robot, q, np.zeros(2), 1e-6)
        assert (bounds.rows @ (0.5 * np.sign(bounds.rows[0])) >= bounds.floor - 1e-12).all()


# ---------------------------------------------------------------------------------------- nothing trips it
@pytest.mark.parametrize("name", ROBOTS)
def test_any_configuration_gives_finite_rows(name, rng):
    robot = rik.load(name)
    hidden = [
        Obstacle(f"in {f}", s, robot.pose(robot.rest, f)) for f, s in zip(robot.description.links, 9 * [Sphere(0.2)])
    ]
    limit = CollisionLimit.of(robot, obstacles=[*around(), *hidden])
    for values in (
        robot.joint_values(robot.rest),
        np.zeros(robot.n),
        np.full(robot.n, 1e9),
        *rng.normal(scale=9, size=(20, robot.n)),
    ):
        q = robot.configuration(values)
        bounds = limit.bounds(robot, q, np.zeros(robot.n), DT)
        assert np.isfinite(bounds.rows).all()
        assert np.isfinite(bounds.floor).all()
        for found in limit.distances(robot, q):
            assert np.isfinite([found.distance, *found.point_a, *found.point_b]).all()


@pytest.mark.parametrize("position", [0.0, 1e-300, 1e-12, 1e20, -1e300, 1.7e308])
@pytest.mark.parametrize("shape", [Sphere(0.05), Box((0.1, 0.1, 0.1)), Cylinder(0.05, 0.1), HalfSpace()])
def test_solids_in_one_place_or_out_of_sight_give_finite_rows(position, shape):
    robot = slider()
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("o", shape)], pairs=[("cart", "o"), ("base", "cart")])
    q = np.array([position])
    bounds = limit.bounds(robot, q, np.zeros(1), DT)
    assert np.isfinite([*bounds.rows.ravel(), *bounds.floor]).all()
    found = limit.distances(robot, q)
    assert len(found) == 2
    assert all(np.isfinite([each.distance, *each.point_a, *each.point_b]).all() for each in found)


@pytest.mark.parametrize("shape", ['<box size="0 0 0"/>', '<sphere radius="0"/>', '<cylinder radius="0" length="0"/>'])
def test_a_shape_without_a_size_is_a_point(shape):
    robot = robot_of(link("base", ""), link("cart", shape), joint("base", "cart", "prismatic"))
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("o", Sphere(0.1), at(0, 0, 0.5))])
    assert limit.distances(robot, [0.1])[0].distance == pytest.approx(0.3, abs=1e-5)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e5])
@pytest.mark.parametrize("rank", [0, 1, 2])
def test_a_flat_mesh_has_a_hull(rank, size, rng):
    points = np.zeros((12, 3))
    points[:, :rank] = size * rng.normal(size=(12, rank))
    turned = points @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    hull = convex_hull(turned)
    there = contact(hull, placed(np.eye(4)), primitive(HalfSpace((0, 0, 1), -5 * size - 1)), placed(np.eye(4)))
    thick = max(LEAST_THICKNESS, 1e-6 * np.abs(turned).max())
    assert there.distance == pytest.approx(turned[:, 2].min() + 5 * size + 1, abs=2 * thick)


@pytest.mark.parametrize("height", [0.3, 0.0])
def test_a_corner_with_more_edges_than_coal_takes_is_kept_inside(height):
    angles = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    base = 0.1 * np.stack([np.cos(angles), np.sin(angles), np.zeros(1000)], axis=-1)
    points = np.concatenate([base, [[0, 0, height]]])
    hull = convex_hull(points)
    for normal in [*np.eye(3), *-np.eye(3), (1, 2, 3), (-3, 2, -1)]:
        plane = HalfSpace(normal, -1.0)
        true = (points @ plane.normal).min() + 1
        assert (
            true - 5e-4 < contact(hull, placed(np.eye(4)), primitive(plane), placed(np.eye(4))).distance < true + 1e-9
        )


@pytest.mark.parametrize("name", ["asr_twodof", "centauro", "icub", "tiago", "puma560"])
def test_whole_robots_can_be_watched(name, rng):
    robot = rik.load(name, whole_tree=True) if name != "puma560" else rik.load(name)
    limit = CollisionLimit.of(robot, obstacles=around())
    assert limit.pairs
    for q in robot.random(rng, 3):
        assert np.isfinite(limit.bounds(robot, q, np.zeros(robot.n), DT).rows).all()


@pytest.mark.parametrize("failure", ["raises", "gives NaN", "gives no normal"])
@pytest.mark.parametrize("shape", [Sphere(0.1), Box((0.2, 0.3, 0.4)), HalfSpace((1, 2, 3), 0.4)])
def test_where_coal_fails_the_spheres_around_are_taken(shape, failure, monkeypatch, rng):
    a, b, pose = primitive(Box((0.1, 0.2, 0.3))), primitive(shape), at(0.7, 0.2, 0.9, 0.5)
    true = contact(a, placed(pose), b, placed(at(0, 0.1, 0)))

    def distance(*given):
        if failure == "raises":
            raise RuntimeError
        given[-1].min_distance = math.nan if failure == "gives NaN" else 1.0
        given[-1].normal = np.zeros(3)

    monkeypatch.setattr(collision_geometry.coal, "distance", distance)
    there = contact(a, placed(pose), b, placed(at(0, 0.1, 0)))
    assert there.distance <= true.distance
    assert there.normal @ true.normal > 0.7
    assert_allclose(there.point_b - there.point_a, there.distance * there.normal, atol=1e-12)
    same = contact(a, placed(pose), primitive(Sphere(0.1)), placed(pose))
    assert np.isfinite([same.distance, *same.normal]).all()


def test_threads_do_not_disturb_each_other_and_copies_are_as_good(rng):
    robot = rik.load("panda")
    limit = CollisionLimit.of(robot, obstacles=around())
    configurations = robot.random(rng, 200)

    def floors(limit):
        return lambda q: limit.bounds(robot, q, np.zeros(robot.n), DT).floor

    alone = [floors(limit)(q) for q in configurations]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(floors(limit), configurations))
    for other in (
        together,
        map(floors(pickle.loads(pickle.dumps(limit))), configurations),
        map(floors(copy.deepcopy(limit)), configurations),
    ):
        for a, b in zip(alone, other):
            assert_allclose(a, b, atol=1e-12)


# ---------------------------------------------------------------------------------------- pairs
def arm():
    return robot_of(
        *(link(name, x=0.1) for name in ("base", "a", "a2", "b", "c")),
        joint("base", "a"),
        joint("a", "a2", "fixed"),
        joint("a2", "b", x=0.5),
        joint("b", "c", x=0.5),
    )


def test_without_an_srdf_rigid_and_adjacent_links_are_left_out():
    limit = CollisionLimit.of(arm())
    assert limit.pairs == (("base", "b"), ("base", "c"), ("a", "c"), ("a2", "c"))
    assert [(each.names, each.reason) for each in limit.ignored] == [
        (("base", "a"), "adjacent"),
        (("base", "a2"), "adjacent"),
        (("a", "b"), "adjacent"),
        (("a2", "b"), "adjacent"),
        (("b", "c"), "adjacent"),
    ]


def test_links_that_touch_at_rest_are_left_out_and_that_is_told():
    robot = robot_of(*(link(name) for name in "abc"), joint("a", "b", x=0.05), joint("b", "c", x=0.05))
    limit = CollisionLimit.of(robot, distance=0.01)
    assert limit.pairs == ()
    assert [each.reason for each in limit.ignored if each.names == ("a", "c")] == ["0 m apart at rest"]
    assert limit.bounds(robot, np.zeros(2), np.zeros(2), DT).rows.shape == (0, 2)


def test_joints_that_are_dropped_hold_their_links_together():
    parts = [*(link(name) for name in "abcd"), joint("a", "b", x=1), joint("b", "c", x=1), joint("a", "d", x=-1)]
    whole, chain = robot_of(*parts, whole_tree=True), robot_of(*parts, tip="c")
    assert ("b", "d") in CollisionLimit.of(whole).pairs
    assert ("a", "c") in CollisionLimit.of(chain).pairs
    # d now belongs to a, which b is jointed to.
    assert ("b", "d") not in CollisionLimit.of(chain).pairs


def test_the_table_a_robot_stands_on_does_not_count_for_what_never_leaves_it():
    robot = robot_of(
        link("base"), link("turret"), link("arm", x=0.5), joint("base", "turret"), joint("turret", "arm", axis="0 1 0")
    )
    limit = CollisionLimit.of(robot, obstacles=[Obstacle("table", HalfSpace((0, 0, 1), -0.06))])
    assert limit.pairs == (("base", "arm"), ("arm", "table"))
    assert [(each.names, each.reason) for each in limit.ignored][-1] == (
        ("turret", "table"),
        "0.01 m apart at rest and never over 0.02 m",
    )


def test_told_pairs_are_the_pairs():
    robot, table = arm(), Obstacle("table", HalfSpace((0, 0, 1), -1))
    limit = CollisionLimit.of(robot, obstacles=[table], pairs=[("table", "c"), ["a", "b"]])
    assert limit.pairs == (("c", "table"), ("a", "b"))
    assert limit.ignored == ()


@pytest.mark.parametrize(
    "pairs, message",
    [
        ([("a", "a2")], "no joint of r moves 'a' relative to 'a2'"),
        ([("a", "a")], "no joint of r moves 'a'"),
        ([("base", "table")], "no joint of r moves 'base' relative to 'table'"),
        ([("a", "elbow")], "no link with a shape is called 'elbow'.*a2"),
        ([("table", "table")], "no link with a shape is called 'table'"),
        (["abc"], "pairs of names, got 'abc'"),
        ([("a", 3)], "pairs of names"),
        (7, "pairs of names, got 7"),
        ([("a", "c")], "obstacle 'table' is in none of the pairs"),
    ],
)
def test_pairs_that_cannot_be_meant_are_refused(pairs, message):
    with pytest.raises(InputError, match=message):
        CollisionLimit.of(arm(), obstacles=[Obstacle("table", HalfSpace((0, 0, 1), -1))], pairs=pairs)


def test_a_robot_without_collision_shapes_is_taken_as_it_looks():
    seen = [link(name, tag="visual") for name in "abc"]
    joints = joint("a", "b", x=1), joint("b", "c", x=1)
    assert CollisionLimit.of(robot_of(*seen, *joints)).pairs == (("a", "c"),)
    mixed = [link("a"), link("b"), link("c", tag="visual")]
    assert CollisionLimit.of(robot_of(*mixed, *joints)).pairs == ()


# ---------------------------------------------------------------------------------------- SRDF
def write_srdf(path, text='<disable_collisions link1="a" link2="c" reason="Never"/>', name="r"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<robot name="{name}">{text}</robot>')
    return path


def write_urdf(path, name="r"):
    path.parent.mkdir(parents=True, exist_ok=True)
    inside = "".join([*(link(n) for n in "abcd"), *(joint(a, b, x=1) for a, b in ("ab", "bc", "cd"))])
    path.write_text(f'<robot name="{name}">{inside}</robot>')
    return path


def test_the_pairs_that_the_srdf_of_panda_disables_are_left_out():
    robot = rik.load("panda")
    path = find("panda").path.parent.parent / "srdf" / "panda.srdf"
    disabled = {frozenset((e.get("link1"), e.get("link2"))) for e in etree.parse(path).iter("disable_collisions")}
    limit = CollisionLimit.of(robot)
    watched = {frozenset(pair) for pair in limit.pairs}
    assert len(disabled) == 35
    assert not watched & disabled
    fixed = ("panda_link7", "panda_hand", "panda_leftfinger", "panda_rightfinger")
    shapes = {visual.link for visual in robot.description.collisions}
    all_pairs = {frozenset(p) for p in combinations(shapes, 2)} - {frozenset(p) for p in combinations(fixed, 2)}
    assert watched == all_pairs - disabled
    assert {each.reason for each in limit.ignored} == {
        f"disabled in panda.srdf: {w}" for w in ("Adjacent", "Never", "Default")
    }


@pytest.mark.parametrize(
    "robot, name",
    [
        ("panda", "panda.srdf"),
        ("panda_collision", "panda.srdf"),
        ("ur5", "ur5.srdf"),
        ("ur5_limited", "ur5_joint_limited_robot.srdf"),
        ("ur10", None),
        ("xarm7", "xarm7.srdf"),
        ("b1_z1", "b1-z1.srdf"),
        ("talos_arm", "talos.srdf"),
        ("baxter", "baxter_manipulation.srdf"),
        ("tiago", None),
    ],
)
def test_the_srdf_beside_a_robot_is_found(robot, name):
    found = find_srdf(rik.load(robot, whole_tree=True) if robot in ("b1_z1", "baxter") else rik.load(robot))
    assert (found and found.path.name) == name


@pytest.mark.parametrize("folder", ["urdf", "robots", "."])
def test_an_srdf_of_the_package_is_found_and_one_given_goes_before_it(tmp_path, folder):
    robot = rik.load(write_urdf(tmp_path / "pkg" / folder / "x.urdf"))
    assert ("a", "c") in CollisionLimit.of(robot).pairs
    write_srdf(tmp_path / "pkg" / "srdf" / "any.srdf")
    assert ("a", "c") not in CollisionLimit.of(robot).pairs
    other = write_srdf(tmp_path / "other.srdf", '<disable_collisions link1="d" link2="b"/>')
    limit = CollisionLimit.of(robot, srdf=other)
    assert ("a", "c") in limit.pairs
    assert ("b", "d") not in limit.pairs
    assert any("no reason given" in each.reason for each in limit.ignored)


def test_of_several_srdfs_only_one_that_is_called_alike_is_taken(tmp_path):
    robot = rik.load(write_urdf(tmp_path / "pkg" / "urdf" / "x.urdf"))
    for name in ("one", "two"):
        write_srdf(tmp_path / "pkg" / "srdf" / f"{name}.srdf")
    assert find_srdf(robot) is None
    write_srdf(tmp_path / "pkg" / "srdf" / "X.srdf")
    assert find_srdf(robot).path.name == "X.srdf"


def test_an_srdf_behind_a_link_out_of_the_package_is_not_read(tmp_path):
    robot = rik.load(write_urdf(tmp_path / "pkg" / "urdf" / "x.urdf"))
    write_srdf(tmp_path / "outside" / "x.srdf")
    (tmp_path / "pkg" / "srdf").mkdir()
    (tmp_path / "pkg" / "srdf" / "x.srdf").symlink_to(tmp_path / "outside" / "x.srdf")
    assert find_srdf(robot) is None
    (tmp_path / "pkg" / "srdf" / "x.srdf").unlink()
    (tmp_path / "pkg" / "srdf").rmdir()
    (tmp_path / "pkg" / "srdf").symlink_to(tmp_path / "outside")
    assert find_srdf(robot) is None


def test_an_srdf_that_disables_nothing_says_nothing(tmp_path):
    robot = arm()
    plain = CollisionLimit.of(robot)
    assert CollisionLimit.of(robot, srdf=write_srdf(tmp_path / "r.srdf", "<group name='g'/>")).pairs == plain.pairs


@pytest.mark.parametrize(
    "content, message",
    [
        ("", "not well-formed"),
        ("<robot", "not well-formed"),
        ("<srdf/>", "root element is <srdf>"),
        ('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot>&x;</robot>', "DOCTYPE.*an SRDF needs none"),
        ('<robot>\n<disable_collisions link1="a"/></robot>', "line 2.*needs link1 and link2"),
        ('<robot><disable_collisions link1="" link2="b"/></robot>', "needs link1 and link2"),
        (
            '<robot name="other"><disable_collisions link1="x" link2="y"/></robot>',
            "for 'other': it names no two links of r",
        ),
        ("\x00\xff", "not well-formed"),
    ],
)
def test_a_broken_srdf_is_refused_with_the_reason(tmp_path, content, message):
    path = tmp_path / "bad.srdf"
    path.write_text(content, encoding="latin-1")
    with pytest.raises(UrdfError, match=f"(?s)bad.srdf.*{message}"):
        CollisionLimit.of(arm(), srdf=path)


def test_an_srdf_that_is_missing_or_too_large_is_refused(tmp_path, monkeypatch):
    with pytest.raises(RobotNotFoundError, match="none.srdf"):
        CollisionLimit.of(arm(), srdf=tmp_path / "none.srdf")
    monkeypatch.setattr(srdf, "MAX_BYTES", 10)
    with pytest.raises(LoadError, match="over 10"):
        read_srdf(write_srdf(tmp_path / "r.srdf"))


# ---------------------------------------------------------------------------------------- meshes
def mesh_arm(tmp_path, name):
    shape = f'<mesh filename="{name}" scale="0.001 0.001 0.001"/>'
    path = tmp_path / "pkg" / "urdf" / "m.urdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    inside = link("a", "") + link("b", shape) + joint("a", "b", "prismatic", axis="1 0 0")
    path.write_text(f'<robot name="m">{inside}</robot>')
    return path


def test_a_mesh_is_its_convex_hull(tmp_path):
    path = mesh_arm(tmp_path, "../meshes/ring.stl")
    (tmp_path / "pkg" / "meshes").mkdir()
    trimesh.creation.annulus(50, 200, 100).export(tmp_path / "pkg" / "meshes" / "ring.stl")
    robot = rik.load(path)
    obstacles = [Obstacle("beside", Sphere(0.1), at(0.5, 0, 0)), Obstacle("in the hole", Sphere(0.01))]
    limit = CollisionLimit.of(robot, obstacles=obstacles, pairs=[("b", "beside"), ("b", "in the hole")])
    apart = {each.names[1]: each.distance for each in limit.distances(robot, [0.05])}
    assert apart["beside"] == pytest.approx(0.15, abs=1e-3)
    assert apart["in the hole"] == pytest.approx(-0.06, abs=1e-3)


@pytest.mark.parametrize(
    "name, reason", [("gone.stl", "not found"), ("broken.stl", "holds no triangles"), ("x.png", "is none of")]
)
def test_a_mesh_that_cannot_be_read_is_refused_where_it_is_needed(tmp_path, name, reason):
    path = mesh_arm(tmp_path, f"../meshes/{name}")
    (tmp_path / "pkg" / "meshes").mkdir()
    (tmp_path / "pkg" / "meshes" / "broken.stl").write_bytes(b"solid x\nfacet")
    robot = rik.load(path)
    assert CollisionLimit.of(robot).pairs == ()
    with pytest.raises(LoadError, match=rf"link 'b' need its mesh '../meshes/{name}'.*{reason}"):
        CollisionLimit.of(robot, obstacles=[Obstacle("o", Sphere(0.1))])


def test_meshes_outside_the_folders_are_not_read(tmp_path):
    trimesh.creation.box().export(tmp_path / "secret.stl")
    for name in (str(tmp_path / "secret.stl"), "../../secret.stl"):
        robot = rik.load(mesh_arm(tmp_path, name))
        with pytest.raises(LoadError, match="is outside"):
            CollisionLimit.of(robot, obstacles=[Obstacle("o", Sphere(0.1))])
    (shape,) = (visual.shape for visual in robot.description.collisions)
    assert isinstance(shape, Mesh)
    assert shape.path is None


# ---------------------------------------------------------------------------------------- bad input
@pytest.mark.parametrize(
    "shape",
    [
        Sphere(0.0),
        Sphere(-1.0),
        Sphere(math.nan),
        Sphere("1"),
        Box((1.0, 0.0, 1.0)),
        Box((1.0, 1.0)),
        Box(1.0),
        Cylinder(1.0, math.inf),
        Cylinder(1e9, 1.0),
        "ball",
        None,
        Mesh("x.stl", None, (1, 1, 1), None),
    ],
)
def test_an_obstacle_of_no_shape_is_refused(shape):
    with pytest.raises(InputError, match="obstacle 'o'"):
        Obstacle("o", shape)


@pytest.mark.parametrize(
    "placement", [np.eye(3), 2 * np.eye(4), np.full((4, 4), np.nan), np.stack([np.eye(4)] * 2), at(1e9, 0, 0), "here"]
)
def test_an_obstacle_of_no_pose_is_refused(placement):
    with pytest.raises(InputError, match="the placement of obstacle 'o'"):
        Obstacle("o", Sphere(0.1), placement)


@pytest.mark.parametrize(
    "normal, offset",
    [((0, 0, 0), 0), ((0, 1), 0), ((0, 0, math.nan), 0), ((0, 0, 1), math.inf), ("up", 0), ([[0, 0, 1]], 0)],
)
def test_a_half_space_without_a_plane_is_refused(normal, offset):
    with pytest.raises(InputError):
        HalfSpace(normal, offset)


def test_obstacles_need_names_of_their_own():
    for names in (["b"], ["o", "o"]):
        with pytest.raises(InputError, match=f"are called '{names[0]}'"):
            CollisionLimit.of(arm(), obstacles=[Obstacle(name, Sphere(0.1)) for name in names])
    with pytest.raises(InputError, match="needs a name"):
        Obstacle("", Sphere(0.1))
    for wrong in (Sphere(0.1), [Sphere(0.1)], 3):
        with pytest.raises(InputError, match="obstacles must be Obstacle"):
            CollisionLimit.of(arm(), obstacles=wrong)


def test_an_obstacle_cannot_be_changed():
    obstacle = pickle.loads(pickle.dumps(Obstacle("o", Sphere(0.1))))
    with pytest.raises(ValueError, match="read-only"):
        obstacle.placement[0, 3] = 1


@pytest.mark.parametrize(
    "options, message",
    [
        ({"distance": -0.1}, "distance must be ≥ 0"),
        ({"distance": 0.1, "influence": 0.1}, "influence must be > 0.1"),
        ({"gain": 0.0}, "gain must be > 0"),
        ({"recovery_speed": math.nan}, "recovery_speed must be > 0"),
    ],
)
def test_parameters_that_cannot_be_meant_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        CollisionLimit.of(arm(), **options)


def test_the_limits_of_another_robot_are_refused():
    limit = CollisionLimit.of(arm())
    for call in (
        lambda: limit.bounds(planar(), np.zeros(2), np.zeros(2), DT),
        lambda: limit.distances(planar(), np.zeros(2)),
    ):
        with pytest.raises(InputError, match="these limits are for base_a, a2_b, b_c"):
            call()
    with pytest.raises(InputError, match="one configuration"):
        limit.distances(arm(), np.zeros((2, 3)))
