"""Rounded numbers in files, small offsets by design, and what the atlas makes of both."""

import json

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.description.urdf.written_digits import last_place, rounding_of_angles
from robust_ik.singularities.atlas.corank_search import CorankSearch
from robust_ik.singularities.atlas.search_run import NEAR
from robust_ik.singularities.geometry.coincidence_tolerance import Tolerance
from robust_ik.singularities.geometry.line_arm import LineArm
from robust_ik.singularities.geometry.screw_chain import ScrewChain, axes_at_zero
from robust_ik.singularities.geometry.straightening import nearby, straightened
from tests.rounded_arms import ARMS, DIGITS, VendorArm, shape

RIGHT = float(np.pi / 2)
PUMA = ((0, 0.6718, 0, RIGHT), (0, 0.1397, 0.4318, 0), (0, 0, 0.0203, -RIGHT), (0, 0.4331, 0, RIGHT),
        (0, 0, 0, -RIGHT), (0, 0, 0, 0))  # fmt: skip
SPHERICAL = ((0, 0.34, 0, -RIGHT), (0, 0, 0, RIGHT), (0, 0.4, 0, RIGHT), (0, 0, 0, -RIGHT), (0, 0.39, 0, -RIGHT),
             (0, 0, 0, RIGHT), (0, 0.1, 0, 0))  # fmt: skip


def with_(links, **changes):
    """The links with "d4", "a2" or "alpha3" (joints from 1) larger by so much."""
    changed = [list(link) for link in links]
    for name, amount in changes.items():
        changed[int(name[-1]) - 1][["theta", "d", "a", "alpha"].index(name[:-1])] += amount
    return VendorArm(tuple(map(tuple, changed)), (0.0, 0.0, 0.1), 1)


def pattern(chain, robot):
    """Which lengths are zero, which are alike, and which angles are nominal, of the ways between the axes."""
    axes, points = axes_at_zero(chain.rotations, chain.offsets)
    arm = LineArm.of(axes, points, robot.pose(robot.neutral)[:3, 3])
    lengths = np.abs([(link.d, link.a) for link in arm.links]).ravel()[1:]
    alike = np.abs(lengths[:, None] - lengths) < 1e-9
    twists = [round(abs(link.alpha) / RIGHT * 1e6) / 1e6 for link in arm.links]
    turns = np.array([link.theta for link in arm.links[1:]])
    nominal = np.abs(turns - RIGHT * np.round(turns / RIGHT)) < 1e-9
    return (lengths < 1e-9).tolist(), alike.tolist(), twists, nominal.tolist()


@pytest.mark.parametrize("digits", DIGITS)
def test_rounded_arms_get_back_the_coincidences_that_were_meant(digits):
    """Two lengths of different links that differ by less than the last digit say nothing of what was meant."""
    more = 0
    for seed in range(ARMS):
        arm = VendorArm.drawn(seed)
        exact, rounded = arm.robot(), arm.robot(digits, turned=bool(seed % 2))
        meant = pattern(ScrewChain.of(exact), exact)
        chain, _, _ = straightened(rounded, ScrewChain.of(rounded))
        zero, alike, twists, turns = pattern(chain, rounded)
        assert zero == meant[0], seed
        assert twists == meant[2], seed
        assert (np.array(alike) >= np.array(meant[1])).all(), seed
        more += alike != meant[1]
        assert turns == meant[3], seed
    assert more <= (2 if digits == min(DIGITS) else 0)


@pytest.mark.parametrize("seed", [3, 4, 7, 8, 14, 17])
def test_rounded_arms_have_the_rows_of_the_exact_ones_and_say_how_near_they_come(seed):
    arm = VendorArm.drawn(seed)
    wanted = rik.find_singularities(arm.robot(), starts=300, certify=False)
    for digits in (3, 4):
        robot = arm.robot(digits, turned=bool(seed % 2))
        found = rik.find_singularities(robot, starts=300, certify=False)
        assert shape(found) == shape(wanted)
        assert "are rounded" in found.explanation
        for row in found:
            s = np.linalg.svd(robot.jacobian(robot.configuration(row.samples)), compute_uv=False)
            assert s[:, 6 - row.corank].max() < 30 * 10.0**-digits
            assert row.floor <= row.off * (1 + 1e-9) or row.floor == 0


@pytest.mark.parametrize("digits", [3, 4])
def test_proofs_are_of_the_arm_that_was_meant(digits):
    atlas = rik.find_singularities(with_(PUMA).robot(digits, turned=True), 1, starts=200)
    assert [row.words for row in atlas][-1] == "q5 ∈ {0, π}"
    assert len(atlas) == 3
    assert atlas.evidence[0].words.startswith("certified")
    (wrist,) = [row for row in atlas if row.words == "q5 ∈ {0, π}"]
    assert 0 < wrist.off < 10.0**-digits * 3


# ------------------------------------------------------------------------------------ how a file is written
@pytest.mark.parametrize(
    ("numbers", "place"),
    [((0.316, 0.0825, 0.1), 1e-4), ((0.333, -0.316), 1e-3), ((1.0, 2.0), 1.0), ((0.0, 0.0), 0.0), ((), 0.0),
     ((300.0, 150.0), 10.0), ((1e-7, 3.25e-6), 1e-8), ((5e-324,), 0.0), ((0.1 + 0.2,), 0.1), ((np.pi, 0.1), 0.0)],
)  # fmt: skip
def test_the_place_of_the_last_digit(numbers, place):
    assert last_place(numbers) == pytest.approx(place, rel=1e-12)


@pytest.mark.parametrize(
    ("angles", "place"),
    [((1.571, 0.123), 1e-3), ((1.5708, -3.1416, 0.5), 1e-4), ((1.57,), 1e-2), ((RIGHT, 0.123), 0.0), ((0.5,), 0.0),
     ((1.6,), 0.0), ((0.123, 0.456), 0.0), ((0.0,), 0.0), ((0.785, 0.262), 1e-3), ((1.572,), 0.0)],
)  # fmt: skip
def test_angles_are_rounded_if_one_is_a_rounded_nominal_one_and_none_is_exact(angles, place):
    assert rounding_of_angles(angles) == pytest.approx(place, abs=1e-15)


def test_files_that_are_written_in_full_allow_no_more_than_noise():
    assert Tolerance.of(rik.load("ur5")) == Tolerance(1e-4, 2e-5, 2e-5)
    assert Tolerance.of(with_(PUMA).robot(3)).short > 1e-3
    fine, coarse = (Tolerance.of(with_(PUMA).robot(digits, turned=True)) for digits in (6, 3))
    assert fine == Tolerance(1e-4, 2e-5, 2e-5)
    assert coarse.angle > 1e-3
    assert coarse.place == 1e-3


def test_lengths_that_differ_by_the_last_digit_are_meant_to():
    links = list(with_(SPHERICAL).links)
    links[2], links[4] = (0, 0.4, 0, RIGHT), (0, 0.401, 0, -RIGHT)
    robot = VendorArm(tuple(links), (0.0, 0.0, 0.0), 1).robot(3)
    chain, _, lines = straightened(robot, ScrewChain.of(robot))
    assert {round(abs(link.d), 9) for link in lines.links} >= {0.4, 0.401}
    assert chain.n == 7


# ------------------------------------------------------------------------------------ coincidences of design
def test_an_offset_wrist_is_nearly_singular_where_one_without_offset_is(tmp_path):
    robot = with_(PUMA, a4=0.00041237).robot()
    atlas = rik.find_singularities(robot, 1, starts=300, certify=False)
    assert "q5 ∈ {0, π}" not in [row.words for row in atlas]
    near = {row.words: row for row in atlas.nearly}
    assert {"q5 ∈ {0, π}", "q3 ∈ {−1.523959, 1.617633}"} <= set(near)
    assert "nearly singular, for small tilts and offsets (q5: lengths changed by 0.00041 m)" in atlas.explanation
    for row in near.values():
        s = np.linalg.svd(robot.jacobian(robot.configuration(row.samples)), compute_uv=False)
        assert s[:, -1].max() <= row.off * (1 + 1e-6)
        assert 1e-6 < row.off < 1e-3
        assert f"{row.words}: σ up to {row.off:.1g} was met there" in atlas.explanation
    assert rik.SingularityAtlas.load(atlas.save(tmp_path / "atlas.json")).markdown() == atlas.markdown()


def test_a_tilted_shoulder_is_nearly_singular_where_a_straight_one_is():
    robot = with_(PUMA, alpha2=np.radians(0.5)).robot()
    atlas = rik.find_singularities(robot, starts=300, certify=False)
    near = [row for row in atlas.nearly if row.words.startswith("q2 = ±π/2 and q3 ∈")]
    assert [row.corank for row in near] == [2]
    assert near[0].floor > 1e-4
    assert f"it falls to {near[0].floor:.1g} nearby" in atlas.explanation


def test_what_a_shoulder_with_a_small_offset_has_itself_is_not_told_again():
    atlas = rik.find_singularities(with_(SPHERICAL, a1=0.00041237).robot(), starts=200, certify=False)
    assert [row.corank for row in atlas.nearly] == [3]
    assert "q4 ∈ {0, π}" in [row.words for row in atlas]


@pytest.mark.parametrize("links", [PUMA, SPHERICAL])
def test_exact_arms_are_near_no_other(links):
    robot = with_(links).robot()
    given = ScrewChain.of(robot)
    assert nearby(robot, given, straightened(robot, given)[0]) == (None, ())


def test_an_interrupted_look_for_nearly_singular_families_is_told_and_keeps_those_that_were_found(monkeypatch):
    atlas = rik.find_singularities(with_(PUMA, a4=0.00041237).robot(), 1, starts=200, certify=False)
    read = CorankSearch.read

    def stopped(search, starts):
        if starts == NEAR:
            raise KeyboardInterrupt
        return read(search, starts)

    monkeypatch.setattr(CorankSearch, "read", stopped)
    again = rik.find_singularities(with_(PUMA, a4=0.00041237).robot(), 1, starts=200, certify=False)
    assert again.interrupted
    assert not again.nearly
    assert "interrupted" in again.explanation
    assert [row.words for row in again] == [row.words for row in atlas]
    more = atlas.extended(20)
    assert more.interrupted
    assert more.nearly == atlas.nearly


@pytest.mark.parametrize(
    ("place", "value"),
    [(("robot", "length_scale"), "a"), (("robot", "length_scale"), 0), (("robot", "length_scale"), None),
     (("robot", "near", "length_scale"), 2.0), (("robot", "near", "sliding"), [True] * 6),
     (("robot", "snapped"), "yes"),
     (("robot", "near_changes"), [1]), (("robot", "near_changes"), None), (("nearly", 0, "inside"), [[1.0] * 9]),
     (("robot", "chain", "slides"), []), (("robot", "floating"), [1])],
)  # fmt: skip
def test_atlases_with_nonsense_in_them_do_not_load(place, value, tmp_path):
    atlas = rik.find_singularities(with_(PUMA, a4=0.00041237).robot(), 1, starts=60, certify=False)
    path = atlas.save(tmp_path / "atlas.json")
    data = json.loads(path.read_text())
    inner = data
    for step in place[:-1]:
        inner = inner[step]
    assert inner[place[-1]] != value
    inner[place[-1]] = value
    path.write_text(json.dumps(data))
    with pytest.raises(rik.LoadError):
        rik.SingularityAtlas.load(path)


def test_rows_of_nearly_the_same_arm_are_tried_when_an_atlas_is_read(tmp_path):
    atlas = rik.find_singularities(with_(PUMA, a4=0.00041237).robot(), 1, starts=200, certify=False)
    path = atlas.save(tmp_path / "atlas.json")
    text = path.read_text()
    spoilt = text.replace('"near": {', '"near": null, "other": {', 1)
    assert spoilt != text
    path.write_text(spoilt)
    with pytest.raises(rik.LoadError):
        rik.SingularityAtlas.load(path)
    words = '"nearly": ['
    assert words in text
    head, tail = text.split(words)
    path.write_text(head + words + tail.replace("3.141592653589793", "3.0"))
    with pytest.raises(rik.LoadError, match="are not singular"):
        rik.SingularityAtlas.load(path)
