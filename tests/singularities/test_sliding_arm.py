"""Arms that slide, by the normals of what turns and the directions of slides, wherever the zeros of slides are."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import robust_ik as rik
from robust_ik.certificates.certify import plain_arm
from robust_ik.certificates.prover import arm_of_moves
from robust_ik.singularities.conditions.robot_facts import jacobians_apart
from robust_ik.singularities.geometry import sliding_arm
from robust_ik.singularities.geometry.coincidence_tolerance import Tolerance
from robust_ik.singularities.geometry.line_arm import made_parallel, transform
from robust_ik.singularities.geometry.screw_chain import ScrewChain, axes_at_zero
from robust_ik.singularities.geometry.sliding_arm import SlidingArm
from robust_ik.singularities.geometry.straightening import straightened
from tests.arms import arm_of
from tests.rounded_arms import DIGITS, SLIDING, VendorArm, shape

EXACT = Tolerance(1e-9, 1e-9, 1e-9)
ARMS = 60
RIGHT = float(np.pi / 2)
STANFORD = ((0, 0.412, 0, -RIGHT), (0, 0.154, 0, RIGHT), (0, 0, 0, 0), (0, 0.2, 0, -RIGHT), (0, 0, 0, RIGHT),
            (0, 0, 0, 0))  # fmt: skip


def drawn(seed, nominal):
    """Lines of an arm of any joints: axes, points, the tip, and which slide."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    sliding = rng.random(n) < 0.4
    sliding[rng.integers(n)] = False
    if nominal:
        axes = np.eye(3)[rng.integers(3, size=n)] * rng.choice([-1, 1], (n, 1))
    else:
        axes = rng.standard_normal((n, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = rng.uniform(-0.5, 0.5, (n, 3)) * (rng.random((n, 3)) < 0.6)
    return axes, points, rng.uniform(-0.3, 0.3, 3), tuple(sliding.tolist())


def found(arm):
    """The lines that an arm's moves lead to."""
    frame, frames = np.eye(4), []
    for each in arm.moves:
        frame = frame @ transform(each)
        frames.append(frame)
    frames = np.stack(frames)
    return frames[:-1, :3, 2], frames[:-1, :3, 3], frames[-1, :3, 3]


def lengths(arm):
    """What is told of an arm beside zeros: lengths, twists and turns of normals, headings and tilts of slides.

    Feet on the first of parallel axes are anywhere, and so are normals of axes in one line.
    """
    told, crossed, directed = [], False, False
    for link in arm.lines.links:
        told += [link.d if crossed else 0.0, link.a, np.cos(link.alpha), np.cos(link.theta) if directed else 1.0]
        crossed, directed = crossed or abs(np.sin(link.alpha)) > 1e-6, directed or link.has_normal
    return np.array([*told, *(np.cos(angle) for each in arm.slides for angle in (each.heading, each.tilt))])


@pytest.mark.parametrize("nominal", [True, False])
def test_an_arm_that_slides_has_its_lines(nominal):
    """Those of slides up to where they are."""
    for seed in range(150):
        axes, points, tip, sliding = drawn(seed, nominal)
        arm = SlidingArm.of(axes, points, tip, sliding, EXACT)
        for each in (arm, arm.evened(EXACT)[0]):
            z, p, end = found(each)
            turns = ~np.array(sliding)
            np.testing.assert_allclose(z, axes, atol=1e-9)
            np.testing.assert_allclose(np.cross(p - points, axes)[turns], 0, atol=1e-8)
            np.testing.assert_allclose(end, tip, atol=1e-8)


@pytest.mark.parametrize("nominal", [True, False])
def test_lengths_do_not_hang_on_zeros_of_slides_or_the_mount(nominal, monkeypatch):
    monkeypatch.setattr(sliding_arm, "LEADS", 1e-6)  # no slide is across by chance
    for seed in range(150):
        axes, points, tip, sliding = drawn(seed, nominal)
        if not nominal and any(one and other for one, other in pairwise(sliding)):
            continue  # two slides across the first axis leave one of their zeros open, and the feet on the next axis
        one = SlidingArm.of(axes, points, tip, sliding, EXACT)
        rng = np.random.default_rng(seed)
        R, moved = Rotation.random(random_state=seed).as_matrix(), points.copy()
        for joint in np.flatnonzero(sliding):
            way = rng.uniform(-0.3, 0.3) * axes[joint]
            moved[joint + 1 :] += way
            tip = tip + way
            moved[joint] += rng.uniform(-0.3, 0.3, 3)  # a slide is nowhere
        other = SlidingArm.of(axes @ R.T, moved @ R.T + 0.7, R @ tip + 0.7, sliding, EXACT)
        np.testing.assert_allclose(lengths(other), lengths(one), atol=1e-7)


def test_what_nearly_meets_meets_and_slides_that_are_nearly_parallel_are():
    for seed in range(60):
        axes, points, tip, sliding = drawn(seed, True)
        one = lengths(SlidingArm.of(axes, points, tip, sliding, EXACT))
        rng, most = np.random.default_rng(seed), Tolerance(1e-4, 2e-5, 2e-5)
        turned = Rotation.from_rotvec(rng.uniform(-2e-6, 2e-6, (len(axes), 3))).apply(axes)
        off = points + rng.uniform(-2e-6, 2e-6, points.shape)
        *lines, _ = made_parallel(turned, off, tip, most.angle, sliding)
        even, changes = SlidingArm.of(*lines, sliding, most).evened(most)
        assert len(changes) == len(axes) - 1
        # A length is what it was, or so is none where it was none; the first normal of an axis is any.
        assert ((np.abs(lengths(even)) < 1e-9) == (np.abs(one) < 1e-9)).all()
        np.testing.assert_allclose(lengths(even), one, atol=2e-4)


def test_the_exact_arm_slides_too():
    for seed in range(12):
        robot = VendorArm.sliding(seed).robot(4, turned=bool(seed % 2))
        chain, _, lines = straightened(robot, ScrewChain.of(robot))
        assert isinstance(lines, SlidingArm)
        told = robot.name, chain.joint_names, chain.rows, lines.moves, robot.length_scale
        arm = arm_of_moves(*told, frozenset(np.flatnonzero(chain.sliding).tolist()))
        assert jacobians_apart(chain, plain_arm(arm)) < 1e-9


def test_an_arm_that_only_slides_keeps_its_lengths():
    joints = [("0 0 0.1000001", "0 0 0", axis, -1, 1, "slide") for axis in ("0 0 1", "1 0 0.000003")]
    robot = arm_of(joints, "0 0 0.1")
    chain, changes, lines = straightened(robot, ScrewChain.of(robot))
    assert lines is None
    assert len(changes) == 1
    np.testing.assert_allclose(chain.offsets, ScrewChain.of(robot).offsets, atol=1e-6)


# ------------------------------------------------------------------------------------------------ rounded files
def pattern(chain, robot):
    """Which lengths are zero, which are alike, and which angles are nominal, of axes and slides."""
    axes, points = axes_at_zero(chain.rotations, chain.offsets)
    arm = SlidingArm.of(axes, points, robot.pose(robot.neutral)[:3, 3], chain.sliding, EXACT)
    sizes = np.abs([(link.d, link.a) for link in arm.lines.links]).ravel()[1:]
    twists = [round(abs(link.alpha) / RIGHT, 6) for link in arm.lines.links]
    turns = np.array([link.theta for link in arm.lines.links[1:]])
    ways = [(round(abs(each.heading) / RIGHT, 6), round(each.tilt / RIGHT, 6)) for each in arm.slides]
    nominal = np.abs(turns - RIGHT * np.round(turns / RIGHT)) < 1e-9
    return ((sizes < 1e-9).tolist(), twists, nominal.tolist(), ways), np.abs(sizes[:, None] - sizes) < 1e-9


@pytest.mark.parametrize("digits", DIGITS)
def test_rounded_arms_that_slide_get_back_the_coincidences_that_were_meant(digits):
    for seed in range(ARMS):
        arm = VendorArm.sliding(seed)
        exact, rounded = arm.robot(), arm.robot(digits, turned=bool(seed % 2))
        meant, alike = pattern(ScrewChain.of(exact), exact)
        chain, _, _ = straightened(rounded, ScrewChain.of(rounded))
        got, now = pattern(chain, rounded)
        assert got == meant, seed
        assert (now >= alike).all(), seed


@pytest.mark.parametrize("seed", [3, 4, 7, 9, 10, 21])
def test_rounded_arms_that_slide_have_the_rows_of_the_exact_ones(seed):
    assert {3, 4, 7, 9, 10, 21} - set(range(len(SLIDING)))
    arm = VendorArm.sliding(seed)
    wanted = rik.find_singularities(arm.robot(), starts=300, certify=False)
    for digits in (3, 4):
        robot = arm.robot(digits, turned=bool(seed % 2))
        atlas = rik.find_singularities(robot, starts=300, certify=False)
        assert shape(atlas) == shape(wanted)
        assert atlas.robot.chain.full_rank == wanted.robot.chain.full_rank
        for row in atlas:
            s = np.linalg.svd(robot.jacobian(robot.configuration(row.samples)), compute_uv=False)
            assert s[:, atlas.robot.chain.full_rank - row.corank].max() < 30 * 10.0**-digits


@pytest.mark.parametrize("digits", [3, 4])
def test_proofs_are_of_the_sliding_arm_that_was_meant(digits, tmp_path):
    links = list(STANFORD)
    links[3] = (0, 0.2 + 1e-3 / 3, 0, -RIGHT)
    robot = VendorArm(tuple(links), (0.0, 0.0, 0.1), 3, (2,)).robot(digits, turned=True)
    atlas = rik.find_singularities(robot, 1, starts=200)
    assert [row.dimension for row in atlas][:2] == [5, 5]
    assert "q5 ∈ {0, π}" in [row.words for row in atlas]
    assert atlas.evidence[0].words.startswith("certified")
    assert "rounded" in atlas.explanation
    assert rik.SingularityAtlas.load(atlas.save(tmp_path / "atlas.json")).markdown() == atlas.markdown()


def test_a_telescope_with_an_offset_wrist_is_nearly_singular_where_one_without_is():
    links = [list(each) for each in STANFORD]
    links[3][2] = 0.00041237
    robot = VendorArm(tuple(map(tuple, links)), (0.0, 0.0, 0.1), 1, (2,)).robot()
    atlas = rik.find_singularities(robot, 1, starts=300, certify=False)
    assert "q5 ∈ {0, π}" not in [row.words for row in atlas]
    near = {row.words: row for row in atlas.nearly}
    assert "q5 ∈ {0, π}" in near
    assert 1e-6 < near["q5 ∈ {0, π}"].off < 1e-3
