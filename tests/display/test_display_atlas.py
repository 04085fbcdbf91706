import base64
import html
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import umsgpack
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.display import plot_curves, write_atlas_html
from robust_ik.display.drawings.family_motions import families
from robust_ik.display.drawings.wrenches import Wrenches
from robust_ik.display.pages.atlas_page import atlas_page
from robust_ik.display.pages.curve_panels import curve_panels
from robust_ik.display.pages.family_page_words import direction_words, screw_words, twist_words
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.singularities import Curve, WrenchScrew, find_singularities, trace
from robust_ik.singularities.trace.torus_curves import pairs, strokes
from tests.arms import LIFT, arm_of
from tests.display.test_display_report import ARM, EVIL, Tags, animations_of, data_of, tracks


@cache
def arm(name):
    return rik.load(name)


@cache
def atlas_of(name, corank=None):
    return find_singularities(arm(name), corank, starts=100)


@cache
def shown(name):
    return families(atlas_of(name), arm(name))


@cache
def page_of(name):
    return atlas_page(atlas_of(name), arm(name))


def text_of(page):
    return html.unescape(" ".join(Tags(page).texts))


def sliding_arm():
    joints = (
        rik.DHJoint(a=0.3, d=0, alpha=1.1),
        rik.DHJoint(a=0.2, d=0, alpha=0.7, kind="prismatic", lower=-0.5, upper=0.8),
        rik.DHJoint(a=0.4, d=0.1, alpha=0.3),
    )
    return Robot.from_dh(rik.DHTable(joints, "standard", rows=("x", "y", "z")))


# ------------------------------------------------------------------------------------------------ what is shown
@pytest.mark.parametrize("name", ["srs_7r", "duleba_3r"])
def test_every_frame_of_every_walk_is_singular_of_its_corank(name):
    robot, rows = arm(name), atlas_of(name).robot.chain.rows
    for family in shown(name):
        s = svd(robot.jacobian(robot.configuration(family.walk.values), rows=rows)).s
        assert (s[:, len(rows) - family.stratum.corank] < 1e-9 * s[:, 0]).all(), family.stratum.words


@pytest.mark.parametrize("name", ["srs_7r", "pa10"])
def test_the_caption_of_the_way_out_says_what_the_family_says(name):
    """An end of reach has no other side, although rounding may leave a curvature of the other sign."""
    sides = {"one side only": "to the other side there is no way", "both sides": "leads to the other side"}
    seen = set()
    for row, family in zip(data_of(page_of(name))["rows"], shown(name), strict=True):
        for said, wanted in sides.items():
            if said in family.stratum.lost.way_out:
                seen.add(said)
                assert wanted in row["sway"]["caption"], family.stratum.words
    assert seen == set(sides)


@pytest.mark.parametrize("name", ["srs_7r", "duleba_3r"])
def test_joint_values_in_the_page_are_those_of_the_walk_in_degrees(name):
    rows = data_of(page_of(name))["rows"]
    for row, family in zip(rows, shown(name), strict=True):
        for motion, expected in ((row["walk"], family.walk), (row["sway"], family.sway)):
            values = np.frombuffer(base64.b64decode(motion["values"]), "<f4").reshape(expected.values.shape)
            assert_allclose(values, np.degrees(expected.values), atol=1e-4)


@pytest.mark.parametrize("name", ["srs_7r", "duleba_3r"])
def test_what_is_marked_as_lost_is_lost_at_every_frame_and_does_not_flicker(name):
    robot, rows = arm(name), atlas_of(name).robot.chain.rows
    places = [ROWS.index(row) for row in rows]
    for family in shown(name):
        twists = family.walk.twists
        J = robot.jacobian(robot.configuration(family.walk.values), rows=rows)
        assert np.abs(np.einsum("fik,fij->fkj", twists[:, places], J)).max() < 1e-9
        gram = np.swapaxes(twists, 1, 2) @ twists
        assert np.abs(gram - np.eye(family.stratum.corank)).max() < 1e-9
        assert np.median(np.abs(np.diff(twists, axis=0)).max(axis=(1, 2))) < 0.1
        assert_allclose(twists[0], family.lost.twists, atol=1e-9)


def test_the_way_out_begins_and_ends_where_the_walk_does():
    for family in shown("srs_7r"):
        for index in (0, -1, len(family.sway.values) // 2):
            assert_allclose(family.sway.values[index], family.walk.values[0], atol=1e-9)
        assert np.ptp(family.sway.marked, axis=0).max() == 0


def test_wrenches_are_drawn_where_the_screws_are():
    for family in shown("srs_7r"):
        drawn = Wrenches.of(family.walk.twists[:1], family.walk.tip[:1], 0.2)
        for index, screw in enumerate(family.lost.screws):
            assert_allclose(np.abs(drawn.axes[0, index] @ screw.axis), 1, atol=1e-6)
            if screw.is_couple:
                assert drawn.forces[0, index] == 0
            else:
                assert screw.distance(drawn.points[0, index]) < 1e-6
                assert_allclose(drawn.pitches[0, index], screw.pitch, atol=1e-6)


# ------------------------------------------------------------------------------------------------ the page
def test_the_page_needs_nothing_from_the_net():
    page = page_of("srs_7r")
    tags = Tags(page)
    for tag, attributes in tags.found:
        for name in ("src", "srcset", "data", "action", "poster", "xlink:href"):
            assert name not in attributes, (tag, name)
        assert not re.match(r"\s*(\w+:)?//", attributes.get("href", "")), tag
        assert not any(name.startswith("on") for name in attributes), tag
    assert not {"img", "iframe", "object", "embed", "base", "form", "a"} & {tag for tag, _ in tags.found}
    style = page.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style
    assert "default-src 'none'" in html.unescape(page)


@pytest.mark.parametrize("name", ["srs_7r", "duleba_3r"])
def test_every_row_of_the_atlas_is_in_the_page_with_a_button_a_card_and_two_motions(name):
    page, atlas = page_of(name), atlas_of(name)
    tags, text = Tags(page), text_of(page)
    buttons = [each for each in tags.of("button") if "data-row" in each]
    assert [each["data-row"] for each in buttons] == [str(index) for index in range(len(atlas))]
    cards = {each["id"] for each in tags.of("tr") if "id" in each}
    assert [each["aria-controls"] in cards for each in buttons] == [True] * len(atlas)
    assert all(each["aria-expanded"] == "false" for each in buttons)
    assert [set(row) for row in data_of(page)["rows"]] == [{"walk", "sway"}] * len(atlas)
    for stratum in atlas:
        assert stratum.words in text
        assert stratum.lost.words in text
    for line in atlas.explanation.splitlines():
        assert line in text


def test_every_animation_loops_and_is_finite():
    for motion in ("walk", "sway"):
        for animation in animations_of(row[motion] for row in data_of(page_of("srs_7r"))["rows"]):
            assert animation["options"] == {"play": True, "repetitions": float("inf")}
            for (path, name), (_, values) in tracks(animation).items():
                assert np.isfinite(values).all()
                if name == ".position" and "/robot/" in path:
                    assert_allclose(values[0], values[-1], atol=1e-5)


def test_the_robot_is_in_the_page_once():
    one = replace(atlas_of("srs_7r"), strata=atlas_of("srs_7r").strata[:1])
    counts = [
        sum(umsgpack.unpackb(base64.b64decode(c))["type"] == "set_object" for c in data_of(page)["scene"])
        for page in (atlas_page(one, arm("srs_7r")), page_of("srs_7r"))
    ]
    # Two trails for every further family; four marks with two looks each for every further lost direction.
    assert counts[1] == counts[0] + 2 * (len(atlas_of("srs_7r")) - 1) + 8 * (atlas_of("srs_7r").highest - 1)


def test_an_empty_atlas_makes_a_page_that_says_so():
    atlas = atlas_of("planar_2r", 2)
    assert len(atlas) == 0
    page = atlas_page(atlas, arm("planar_2r"))
    assert data_of(page)["rows"] == []
    assert "No family of singular configurations was found." in text_of(page)
    assert "none found by 100 starts" in text_of(page)
    assert 'class="atlas empty"' in page


def test_an_interrupted_atlas_is_marked_so():
    assert "The search was stopped" not in text_of(page_of("duleba_3r"))
    page = atlas_page(replace(atlas_of("duleba_3r"), interrupted=True), arm("duleba_3r"))
    assert "The search was stopped" in text_of(page)


def test_a_sliding_joint_is_told_in_metres():
    robot = sliding_arm()
    page = atlas_page(find_singularities(robot, 1, starts=100), robot)
    assert data_of(page)["units"] == ["°", "m", "°"]
    assert "q2 [m]" in text_of(page)


def test_the_same_atlas_gives_the_same_page():
    assert atlas_page(atlas_of("duleba_3r"), arm("duleba_3r")) == page_of("duleba_3r")


def test_an_atlas_of_another_robot_is_refused():
    with pytest.raises(InputError, match="the atlas is of duleba_3r"):
        atlas_page(atlas_of("duleba_3r"), arm("srs_7r"))
    assert arm("puma560").joint_names == arm("puma560_corke").joint_names
    with pytest.raises(InputError, match="the atlas is of puma560"):
        atlas_page(find_singularities(arm("puma560"), 1, starts=5), arm("puma560_corke"))


def test_no_name_can_bring_markup_into_the_page(tmp_path):
    visual = f'<visual><geometry><mesh filename="{html.escape(EVIL)}.stl"/></geometry></visual>'
    path = tmp_path / "arm.urdf"
    name = '"' + html.escape(EVIL) + '"'
    path.write_text(ARM.format(name=name, visual=visual, kind="revolute", axis="0 -1 0"), encoding="utf-8")
    evil = Robot.from_urdf(path, tip="tip", rows=("x", "z"))
    atlas = find_singularities(evil, 1, starts=50)
    for title in ("", EVIL):
        page = atlas_page(atlas, evil, title=title)
        tags = Tags(page)
        assert not tags.of("img")
        assert len(tags.of("script")) == 3
        assert page.count("</script>") == 3
        assert EVIL in text_of(page)


def test_the_page_is_written_where_it_should_be(tmp_path):
    path = tmp_path / "a" / "b.html"
    assert write_atlas_html(path, atlas_of("duleba_3r"), arm("duleba_3r")) == path
    assert path.read_text(encoding="utf-8") == page_of("duleba_3r")
    assert path.stat().st_size < 3_000_000


# ------------------------------------------------------------------------------------------------ curves
def test_a_curve_has_a_panel_for_every_two_of_its_joints():
    atlas = atlas_of("duleba_3r")
    for family in shown("duleba_3r"):
        panels = curve_panels(atlas.robot.chain, family.curves, family.walk.values[0])
        assert panels.count('class="panel"') == bool(family.stratum.relations)
        assert "nan" not in panels


def test_a_curve_over_the_edge_of_its_panel_goes_on_at_the_other_side():
    chain = atlas_of("srs_7r").robot.chain
    q = np.zeros((200, 7))
    q[:, 0], q[:, 1] = np.linspace(0.01, 4 * np.pi + 0.01, 200, endpoint=False), 0.3
    curve = Curve((0, 1), q, True, True, chain.period)
    ((across, up),) = pairs(chain, (curve,))
    pieces = strokes(curve, across, up)
    assert len(pieces) == 3
    for piece in pieces:
        assert np.abs(np.diff(piece, axis=0)).max() < 8
    assert pieces[0][-1, 0] > 180 > pieces[0][-2, 0]
    assert pieces[1][0, 0] < -180 <= pieces[1][1, 0]


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_curves_are_drawn_to_a_file(tmp_path, suffix):
    atlas = atlas_of("duleba_3r")
    (stratum,) = [row for row in atlas if row.relations]
    path = plot_curves(atlas, stratum, tmp_path / "new" / f"curves{suffix}")
    assert path.stat().st_size > 5_000


def test_a_row_without_curves_is_no_figure(tmp_path):
    atlas = atlas_of("duleba_3r")
    stratum = next(row for row in atlas if not row.relations)
    assert trace(atlas, stratum) == ()
    with pytest.raises(InputError, match="no joints are coupled"):
        plot_curves(atlas, stratum, tmp_path / "curves.png")
    with pytest.raises(InputError, match="written as one of"):
        plot_curves(atlas, next(row for row in atlas if row.relations), tmp_path / "curves.txt")


# ------------------------------------------------------------------------------------------------ words
@pytest.mark.parametrize(
    ("twist", "words"),
    [((0, 0, 1, 0, 0, 0), "translation along z"), ((0, 0, 0, 0, -2, 0), "rotation about y"),
     ((0.6, 0, -0.8, 0, 0, 0), "translation along (0.6, 0, −0.8)"),
     ((0.6, 0, 0, 0, 0.8, 0), "translation by (0.6, 0, 0) m with rotation by (0, 0.8, 0) rad")],
)  # fmt: skip
def test_twists_in_words(twist, words):
    assert twist_words(np.array(twist, float)) == words


@pytest.mark.parametrize(
    ("wrench", "words"),
    [((0, 0, 1, 0, 0, 0), "force along z through (1, 0, 0) m"), ((0, 0, 0, 0, 1, 0), "couple about y"),
     ((0, 0, 1, 0, 0, 0.25), "screw along z through (1, 0, 0) m, pitch 0.25 m/rad")],
)  # fmt: skip
def test_wrench_screws_in_words(wrench, words):
    assert screw_words(WrenchScrew.of(np.array(wrench, float), np.array([1.0, 0, 0]))) == words


def test_directions_near_an_axis_are_not_called_it():
    assert direction_words(np.array([1.0, 1e-3, 0])) == "(1, 0.001, 0)"
    assert direction_words(np.array([0, -2.0, 0])) == "y"


def test_the_page_of_an_arm_with_few_joints_says_what_its_corank_counts(tmp_path):
    robot = rik.load(Path(__file__).parents[1] / "data" / "five_dof.urdf")
    page = write_atlas_html(tmp_path / "five.html", rik.find_singularities(robot, starts=60), robot)
    text = page.read_text(encoding="utf-8")
    assert "one motion of the joints does not move the tip" in text
    assert "2 motions of the joints do not move the tip" in text
    assert "direction is lost" not in text


@pytest.mark.parametrize("size", [2.0**-12, 2.0**12])
def test_families_of_arms_that_slide_are_walked_through_in_the_arm_s_own_unit(size):
    robot = arm_of(LIFT, "0.1 0 0", size)
    atlas = rik.find_singularities(robot, 1, starts=100, certify=False)
    assert len(atlas) > 0
    for family in families(atlas, robot):
        assert family.inside == family.stratum.within_limits
        for motion, least in ((family.walk, 0.1), (family.sway, 0.02)):
            span = np.ptp(motion.values, axis=0)
            span[1] /= size
            assert least < span[1] < 1.0
            assert span.max() > 0.3
        s = np.linalg.svd(robot.jacobian(robot.configuration(family.walk.values)), compute_uv=False)
        assert (s[:, -1] < 1e-9 * s[:, 0]).all()
