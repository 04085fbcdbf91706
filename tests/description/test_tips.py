"""Which frame is the tip when none is given: hands rather than fingers, and never a guess between two arms."""

import pytest

import robust_ik as rik
from robust_ik.description.catalog import catalog
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf.urdf_reader import parse_urdf, read_urdf

LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'


def tree(*joints):
    """A robot of joints "parent child length [kind] [mimic]"."""
    text, links = "", {}
    for index, joint in enumerate(joints):
        parent, child, length, *more = joint.split()
        kind, mimic = (*more, "revolute", "")[:2] if len(more) < 2 else more
        inside = f'<mimic joint="{mimic}"/>' if mimic else ""
        text += (
            f'<joint name="j_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="0 0 {length}"/><axis xyz="{int(index % 2 == 0)} {index % 2} 0"/>{LIMIT}{inside}</joint>'
        )
        links.update({parent: None, child: None})
    return parse_urdf(
        f'<robot name="r">{"".join(f"<link name={chr(34)}{link}{chr(34)}/>" for link in links)}{text}</robot>'
    )


ARM = ("base l1 0.3", "l1 l2 0.3", "l2 l3 0.3", "l3 l4 0.3", "l4 l5 0.1", "l5 link6 0.1")
FINGERS = ("hand left 0.05 prismatic", "hand right 0.05 prismatic")


def test_the_one_leaf_of_an_arm_is_its_tip_and_no_guess():
    assert choose_tip(tree(*ARM)) == choose_tip(tree(*ARM, "base camera 0.1 fixed"))
    assert (choose_tip(tree(*ARM)).name, choose_tip(tree(*ARM)).note) == ("link6", "")


@pytest.mark.parametrize(
    "hand, tip",
    [
        (("link6 hand 0.1 fixed", *FINGERS), "hand"),
        (("link6 hand 0.1 fixed", *FINGERS, "hand tcp 0.1 fixed", "link6 camera 0.1 fixed"), "hand"),
        (("link6 left 0.05", "link6 right 0.05"), "link6"),
        (("link6 hand 0.1 fixed", "hand left 0.05", "hand right 0.05 revolute j_left"), "hand"),
        (("link6 hand 0.1 fixed", *FINGERS, "left tip1 0.02 fixed", "right tip2 0.02 fixed"), "hand"),
        (
            ("link6 palm 0.1 fixed", *(f"palm f{i} 0.05" for i in range(4)), *(f"f{i} g{i} 0.05" for i in range(4)),
             "palm thumb 0.05"),
            "palm",
        ),
        (
            ("link6 palm 0.1 fixed", "palm a1 0.05", "a1 a2 0.05", "a2 a3 0.05", "palm b1 0.05", "b1 b2 0.05",
             "palm c1 0.05", "c1 c2 0.05"),
            "palm",
        ),
    ],
)  # fmt: skip
def test_fingers_share_a_hand_which_is_guessed_and_said(hand, tip):
    chosen = choose_tip(tree(*ARM, *hand))
    assert chosen.name == tip
    assert f"no tip was given: '{tip}', the last link that the fingers share" in chosen.note
    assert "--tip" in chosen.note


def test_leaves_of_one_rigid_body_share_a_link_and_tool0_comes_first():
    chosen = choose_tip(tree(*ARM, "link6 ee_link 0.1 fixed", "ee_link a 0 fixed", "ee_link b 0 fixed"))
    assert chosen.name == "ee_link"
    assert "a, b share" in chosen.note
    assert choose_tip(tree(*ARM, "link6 ee_link 0.1 fixed", "link6 tool0 0.1 fixed")).name == "tool0"


def test_a_leaf_that_is_where_its_link_is_counts_for_nothing():
    chosen = choose_tip(tree(*ARM, "link6 flange 0.1 fixed", "link6 link6_sc 0 fixed"))
    assert chosen.name == "flange"
    assert "'flange' is taken, as link6_sc" in chosen.note


@pytest.mark.parametrize(
    "joints, ends",
    [
        ((*ARM, *(joint.replace("l", "m") for joint in ARM)), "link6, mink6"),
        (
            ("base t1 0.1", "t1 t2 0.1", "t2 t3 0.1", "t3 t4 0.1", "t4 a1 0.3", "a1 a2 0.3", "t4 b1 0.3", "b1 b2 0.3"),
            "a2, b2",
        ),
        (("base a1 0.3", "a1 a2 0.3", "base b1 0.3", "b1 b2 0.3"), "a2, b2"),
    ],
)  # fmt: skip
def test_two_arms_are_no_fingers(joints, ends):
    with pytest.raises(rik.TipError, match=f"2 chains of . joints; give a tip .*one of: {ends}"):
        choose_tip(tree(*joints))


def test_what_two_arms_share_is_offered_after_their_hands_and_before_the_fingers():
    arms = [joint.replace("l", side).replace("base", "torso") for side in "LR" for joint in ARM]
    hands = [f"{side}ink6 {side}{finger} 0.05" for side in "LR" for finger in "xy"]
    with pytest.raises(rik.TipError, match="one of: Link6?.*") as caught:
        choose_tip(tree("base torso 0.5 prismatic", *arms, *hands))
    message = str(caught.value)
    assert "one of: Link6, Rink6; or torso, the last link that they share; or another leaf: Lx, Ly, Rx, Ry" in message


def test_followers_that_end_apart_are_not_guessed_between():
    joints = (*ARM[:3], "l3 tool 0.1 revolute j_l3", "l2 rod 0.3 revolute j_l2", "rod rodend 0.1 revolute j_l3")
    with pytest.raises(rik.TipError, match="rodend, tool"):
        choose_tip(tree(*joints))


HANDS = {
    "tiago_dual": "hand_left_palm_link, hand_right_palm_link",
    "pr2": "l_gripper_palm_link, r_gripper_palm_link",
    "talos": "gripper_left_base_link, gripper_right_base_link",
    "g1_with_hands": "left_hand_palm_link, right_hand_palm_link",
    "baxter": "left_gripper_base_link, right_gripper_base_link",
    "tiago_pro": "gripper_left_base_link, gripper_right_base_link",
    "alex_sake_hands": "LeftSakePalmLink, RightSakePalmLink",
    "allegro_left_hand": "link_11.0_tip, link_15.0_tip, link_3.0_tip, link_7.0_tip",
    "anymal_c": "LF_FOOT, LH_FOOT, RF_FOOT, RH_FOOT",
}


@pytest.mark.parametrize("name", HANDS)
def test_robots_with_several_arms_are_asked_about_and_hands_are_offered(name):
    with pytest.raises(rik.TipError, match=f"one of: {HANDS[name]}($|;)"):
        choose_tip(read_urdf(catalog()[name].path))


@pytest.mark.parametrize(
    "name, tip",
    [("panda", "panda_hand"), ("tiago", "hand_palm_link"), ("ur5", "tool0"), ("kinova", "j2s6s200_link_6"),
     ("xarm7", "link_eef"), ("kinova_gen3", "EndEffector_Link"), ("anymal_kinova", "j2s6s200_link_6")],
)  # fmt: skip
def test_the_files_of_known_arms_end_in_their_hands(name, tip):
    assert choose_tip(read_urdf(catalog()[name].path)).name == tip
