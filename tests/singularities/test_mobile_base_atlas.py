"""Atlases of arms on bases that move: what the base makes up for is not listed, and coordinates are not robots."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.urdf import parse_urdf
from robust_ik.description.urdf.mobile_joints import MOST_PITCH
from robust_ik.singularities import Completeness
from robust_ik.singularities.atlas.atlas_record import NoSingularitiesError
from tests.robot.test_mobile_base import scaled

PARTS = 3
"""Joints of a planar base in front of the arm's own."""
SINGULAR = 1e-6
"""σ below this is none: members of families are found to 1e-8 or better, and others are far from it."""


def on_planar(name, **options):
    return rik.find_singularities(rik.load(name, base="planar"), 1, starts=300, certify=False, **options)


def rows_of(atlas):
    return sorted((row.words, row.dimension) for row in atlas)


def left_over(arm, q):
    """The rows that a planar base leaves to an arm: z, wx, wy. It moves along x and y and turns about z by itself."""
    return np.linalg.svd(arm.jacobian(q, rows=("z", "wx", "wy")), compute_uv=False)


# -------------------------------------------------------------------------------------------------- on planar bases
@pytest.mark.parametrize("name", ["ur5", "puma560"])
def test_an_arm_on_a_planar_base_loses_rank_where_it_loses_it_in_the_rows_that_the_base_does_not_move(name, rng):
    """By brute force, at random configurations and at listed ones, from the arm alone."""
    arm, robot, atlas = rik.load(name), rik.load(name, base="planar"), on_planar(name)
    assert len(atlas.of_corank(1)) >= 3
    listed = np.concatenate([row.samples for row in atlas])
    values = np.concatenate([rng.uniform(-3, 3, (500, robot.n)), listed])
    for each in values:
        s = np.linalg.svd(robot.jacobian(robot.configuration(each)), compute_uv=False)
        own = left_over(arm, arm.configuration(each[PARTS:]))
        assert (s < SINGULAR).sum() == (own < SINGULAR).sum()
    assert (left_over(arm, arm.configuration(listed[:, PARTS:]))[:, -1] < SINGULAR).all()


def test_its_families_are_those_of_the_arm_alone_in_these_rows():
    alone = rik.find_singularities(rik.load("puma560"), 1, rows=("z", "wx", "wy"), starts=300, certify=False)
    conditions = []
    for words, dimension in rows_of(on_planar("puma560")):
        for joint in range(PARTS + 1, PARTS + 7):
            words = words.replace(f"q{joint}", f"q{joint - PARTS}")
        conditions.append((words, dimension - PARTS))
    assert sorted(conditions) == rows_of(alone)
    assert any("tan q3 = d4/a3" in words for words, _ in conditions)


def test_no_descent_by_another_method_finds_a_family_that_is_not_listed(rng):
    """Newton's method for σ₆ = 0 from random configurations, with gradients of the robot's own."""
    robot, atlas = rik.load("puma560", base="planar"), on_planar("puma560")
    found = 0
    for values in robot.joint_values(robot.random(rng, 60)):
        for _ in range(60):
            q = robot.configuration(values)
            s = np.linalg.svd(robot.jacobian(q), compute_uv=False)[-1]
            g = robot.singular_value_gradients(q)[-1]
            if s < 1e-9 or g @ g < 1e-12:
                break
            values = values - 0.7 * s * g / max(g @ g, 1e-3)
        if s < 1e-7:
            found += 1
            assert atlas.distance(values).distance < 1e-4
    assert found > 10


def test_where_the_base_stands_and_how_it_is_mounted_changes_nothing():
    plain = rik.load("puma560", base="planar")
    xml = plain.description.xml
    first = '<joint name="base_x" type="prismatic">'
    assert xml.count(first) == 1
    turned = xml.replace(first, first + '<origin xyz="3 -2 0.5" rpy="0.4 -0.7 1.1"/>')
    robot = rik.Robot.from_description(parse_urdf(turned), plain.tip)
    moved = rik.find_singularities(robot, 1, starts=300, certify=False)
    plain = rik.Robot.from_description(parse_urdf(xml), plain.tip)
    assert rows_of(moved) == rows_of(rik.find_singularities(plain, 1, starts=300, certify=False))
    assert len(moved) == 4


@pytest.mark.parametrize("factor", [2.0**-10, 2.0**-5, 2.0**10])
def test_an_arm_of_another_size_on_a_planar_base_has_the_same_families(factor):
    one, other = (rik.find_singularities(scaled(each), starts=200, certify=False) for each in (1.0, factor))
    assert rows_of(one) == rows_of(other)
    assert len(one) > 0


# ------------------------------------------------------------------------------------------------- on floating bases
@pytest.mark.parametrize("name", ["ur5", "puma560", "panda", "duleba_3r", "so100"])
def test_an_arm_on_a_floating_base_is_never_singular_and_the_atlas_says_why(name, rng):
    robot = rik.load(name, base="floating")
    atlas = rik.find_singularities(robot)
    assert len(atlas) == 0
    assert [each.status for each in atlas.evidence] == [Completeness.NEVER]
    assert "none within the limits; base_x to base_roll alone move the tip in all six directions" in atlas.explanation
    assert "at base_pitch = ±π/2 it is 0, which is a singularity of these coordinates" in atlas.explanation
    assert atlas.explanation in str(atlas).replace("\\", "")
    values = robot.joint_values(robot.random(rng, 300))
    values[::2, 4] = MOST_PITCH
    s = np.linalg.svd(robot.jacobian(robot.configuration(values), rows=None), compute_uv=False)
    assert s[:, -1].min() > 1e-3


def floating_body(lower=-MOST_PITCH, inside=""):
    text = ('<robot name="r"><link name="a"/><link name="b"/><joint name="base" type="floating"><parent link="a"/>'
            f'<child link="b"/></joint>{inside}</robot>')  # fmt: skip
    robot = rik.Robot.from_description(parse_urdf(text))
    low, high = robot.lower.copy(), robot.upper.copy()
    low[4], high[4] = lower, -lower
    return replace(robot, lower=low, upper=high)


def test_the_statement_is_computed_from_the_limits_and_the_geometry():
    assert rik.find_singularities(floating_body()).evidence[0].status is Completeness.NEVER
    beyond = rik.find_singularities(floating_body(-np.pi), starts=100, certify=False)
    assert [row.words for row in beyond] == ["q5 = ±π/2"]  # as coordinates of a joint that may turn so far
    small = rik.find_singularities(floating_body(-0.5))
    assert f"at least {np.cos(0.5):.3g} within" in small.explanation


def test_a_floating_joint_that_another_joint_follows_is_searched_like_any_other():
    follows = '<origin xyz="0.3 0.1 0"/><axis xyz="0 0 1"/><mimic joint="base_yaw" multiplier="-1"/>'
    ends = '<parent link="b"/><child link="c"/>'
    inside = f'<link name="c"/><joint name="arm" type="continuous">{ends}{follows}</joint>'
    atlas = rik.find_singularities(floating_body(inside=inside), 1, starts=100, certify=False)
    assert atlas.evidence[0].status is not Completeness.NEVER
    assert len(atlas) > 0


def test_an_atlas_of_a_floating_base_is_written_read_and_continued_and_a_file_cannot_lie(tmp_path):
    atlas = rik.find_singularities(rik.load("ur5", base="floating"))
    path = atlas.save(tmp_path / "atlas.json")
    again = rik.SingularityAtlas.load(path)
    assert again.evidence == atlas.evidence
    assert atlas.extended(10).evidence == atlas.evidence
    fixed = rik.find_singularities(rik.load("planar_2r"), starts=20, certify=False)
    data = json.loads(fixed.save(tmp_path / "fixed.json").read_text())
    data["evidence"] = [{**data["evidence"][0], "status": "NEVER", "fresh": 0}]
    data["strata"] = []
    (tmp_path / "fixed.json").write_text(json.dumps(data))
    assert rik.SingularityAtlas.load(tmp_path / "fixed.json").evidence[0].status is Completeness.INTERRUPTED
    data = json.loads(path.read_text())
    data["robot"]["floating"][0] = "nobody"
    path.write_text(json.dumps(data))
    with pytest.raises(rik.LoadError, match="its floating joint cannot be nobody"):
        rik.SingularityAtlas.load(path)


def test_the_nearest_singularity_of_such_an_arm_is_refused_with_the_reason():
    atlas = rik.find_singularities(rik.load("ur5", base="floating"), 2)
    assert atlas.evidence[0].corank == 2
    with pytest.raises(NoSingularitiesError, match="alone move the tip in all six directions"):
        atlas.raise_for_status()


def test_a_floating_joint_in_the_middle_of_a_chain_counts_as_one_in_front():
    parts = ["base_x", "base_y", "base_z", "base_yaw", "base_pitch", "base_roll"]
    text = "".join(f'<link name="l{i}"/>' for i in range(4))
    for i, (name, kind, xyz) in enumerate(
        [("j0", "continuous", "0 0 1"), ("base", "floating", "0.3 0.1 0"), ("j2", "continuous", "1 0 0")]
    ):
        ends = f'<parent link="l{i}"/><child link="l{i + 1}"/>'
        text += f'<joint name="{name}" type="{kind}">{ends}<origin xyz="{xyz}"/></joint>'
    robot = rik.Robot.from_description(parse_urdf(f'<robot name="r">{text}</robot>'))
    assert list(robot.joint_names) == ["j0", *parts, "j2"]
    assert rik.find_singularities(robot).evidence[0].status is Completeness.NEVER
    assert_allclose(abs(np.linalg.det(robot.jacobian(robot.neutral)[:, 1:7])), 1.0)
