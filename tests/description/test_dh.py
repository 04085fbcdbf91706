import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from robust_ik.description.dh.dh_table import DHJoint, DHTable, screw
from robust_ik.description.dh.dh_toml import MAX_BYTES, read_dh, table_from_toml, table_to_toml
from robust_ik.errors import DHError, InputError, LoadError, RobotNotFoundError

CONVENTIONS = ("standard", "modified")
family = settings(max_examples=40, deadline=None, derandomize=True, database=None)

# ------------------------------------------------------------------------------------------ random tables
angles = st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi]) | st.floats(-math.pi, math.pi)
lengths = st.just(0.0) | st.floats(-1.0, 1.0)


@st.composite
def poses(draw):
    pose = np.eye(4)
    for axis in (2, 1, 0):
        pose = pose @ screw(axis, draw(angles), draw(lengths))
    return pose


@st.composite
def joints(draw):
    row = {"a": draw(lengths), "d": draw(lengths), "alpha": draw(angles), "theta": draw(angles)}
    velocity = draw(st.none() | st.floats(0.1, 9))
    if draw(st.booleans()):
        return DHJoint(kind="prismatic", lower=-0.5, upper=draw(st.floats(0, 2)), velocity=velocity, **row)
    lower, upper = draw(st.none() | st.floats(-3, -1)), draw(st.none() | st.floats(1, 3))
    return DHJoint(lower=lower, upper=upper, velocity=velocity, **row)


@st.composite
def tables(draw):
    rows = tuple(draw(st.permutations(["x", "y", "z", "wx", "wy", "wz"])))[: draw(st.integers(1, 6))]
    chain = draw(st.lists(joints(), min_size=1, max_size=7))
    rest = draw(st.none() | st.just([0.0] * len(chain)))
    convention = draw(st.sampled_from(CONVENTIONS))
    return DHTable(chain, convention, rows=rows, base=draw(poses()), tool=draw(poses()), rest=rest)


def configuration(table, seed=0):
    return np.random.default_rng(seed).uniform(-3, 3, table.n)


def textbook(joint, value, convention):
    """Row matrices as textbooks print them, element by element."""
    turns = joint.kind == "revolute"
    theta, d = joint.theta + value * turns, joint.d + value * (not turns)
    c, s, ca, sa, a = math.cos(theta), math.sin(theta), math.cos(joint.alpha), math.sin(joint.alpha), joint.a
    if convention == "standard":
        rows = [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d]]
    else:
        rows = [[c, -s, 0, a], [s * ca, c * ca, -sa, -d * sa], [s * sa, c * sa, ca, d * ca]]
    return np.array([*rows, [0, 0, 0, 1]])


def equal(one, other):
    arrays = all(np.array_equal(getattr(one, key), getattr(other, key)) for key in ("base", "tool"))
    rest = (one.rest is None) == (other.rest is None) and (one.rest is None or (one.rest == other.rest).all())
    plain = all(getattr(one, key) == getattr(other, key) for key in ("joints", "convention", "name", "rows"))
    return arrays and rest and plain


# --------------------------------------------------------------------------------------------- kinematics
@family
@given(tables())
def test_the_pose_is_base_times_the_textbook_matrices_times_tool(table):
    q = configuration(table)
    expected = table.base
    for joint, value in zip(table.joints, q):
        expected = expected @ textbook(joint, value, table.convention)
    assert_allclose(table.pose(q), expected @ table.tool, rtol=0, atol=1e-13)


@family
@given(tables())
def test_the_jacobian_is_the_derivative_of_the_pose(table):
    q, step = configuration(table), 1e-6
    ahead, behind = table.pose(q + step * np.eye(table.n)), table.pose(q - step * np.eye(table.n))
    slope = (ahead - behind) / (2 * step)
    spin = slope[:, :3, :3] @ table.pose(q)[:3, :3].T
    twists = np.concatenate(
        [slope[:, :3, 3], np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)], axis=-1
    )
    assert_allclose(table.jacobian(q), twists.T, rtol=0, atol=5e-9)


@family
@given(tables())
def test_frames_stand_on_the_joint_axes_and_end_at_the_tip(table):
    q = configuration(table)
    frames = table.frames(q)
    assert_array_equal(frames[-1], table.pose(q))
    for i, joint in enumerate(table.joints):
        alone = table.frames(np.where(np.arange(table.n) == i, q + 0.1, q))[i]
        motion = screw(2, 0.1, 0.0) if joint.kind == "revolute" else screw(2, 0.0, 0.1)
        assert_allclose(alone, frames[i] @ motion, rtol=0, atol=1e-13)


@family
@given(tables())
def test_frames_of_a_modified_table_are_craigs(table):
    table = DHTable(table.joints, "modified", base=table.base, tool=table.tool)
    q, expected = configuration(table), table.base
    for i, joint in enumerate(table.joints):
        expected = expected @ textbook(joint, q[i], "modified")
        assert_allclose(table.frames(q)[i], expected, rtol=0, atol=1e-13)


@family
@given(tables())
def test_a_standard_table_is_the_modified_one_with_a_and_alpha_one_row_up(table):
    standard = DHTable(table.joints, "standard", tool=table.tool)
    before = [(0.0, 0.0), *((joint.a, joint.alpha) for joint in table.joints)]
    last_a, last_alpha = before.pop()
    shifted = [
        DHJoint(a=a, alpha=alpha, d=j.d, theta=j.theta, kind=j.kind, lower=j.lower, upper=j.upper, name=j.name)
        for (a, alpha), j in zip(before, table.joints)
    ]
    modified = DHTable(shifted, "modified", tool=screw(0, last_alpha, last_a) @ table.tool)
    q = configuration(table)
    assert_allclose(modified.pose(q), standard.pose(q), rtol=0, atol=1e-13)
    assert_allclose(modified.jacobian(q), standard.jacobian(q), rtol=0, atol=1e-13)


@pytest.mark.parametrize("batch", [(), (0,), (3,), (2, 3)])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_leading_axes_are_batch_axes(convention, batch):
    row = {"a": 0.3, "d": 0.1, "alpha": 0.7}
    table = DHTable([DHJoint(**row), DHJoint(kind="prismatic", lower=0, upper=1, **row), DHJoint(**row)], convention)
    q = np.random.default_rng(1).normal(size=(*batch, 3))
    assert table.pose(q).shape == (*batch, 4, 4)
    assert table.frames(q).shape == (*batch, 4, 4, 4)
    assert table.jacobian(q).shape == (*batch, 6, 3)
    for index in np.ndindex(batch):
        assert_array_equal(table.pose(q)[index], table.pose(q[index]))
        assert_array_equal(table.jacobian(q)[index], table.jacobian(q[index]))


def test_nothing_that_is_stored_can_be_written_to_and_nothing_given_is_kept():
    base = screw(2, 0.3, 0.4)
    rest = np.zeros(1)
    table = DHTable([DHJoint(a=1, d=0, alpha=0)], "standard", base=base, rest=rest)
    base[0, 3], rest[0] = 9.0, 9.0
    assert table.base[0, 3] == 0
    assert table.rest[0] == 0
    names = ("base", "tool", "rest", "lower", "upper", "velocity", "revolute", "placements")
    assert not any(getattr(table, name).flags.writeable for name in names)
    q = np.zeros(1)
    q.setflags(write=False)
    before = table.pose(q)
    table.pose(q)[0, 0] = 5.0
    assert_array_equal(table.pose(q), before)


def test_what_is_not_stated_is_unlimited_and_named_by_its_place():
    joints = [
        DHJoint(a=1, d=0, alpha=0, lower=-2.0),
        DHJoint(a=1, d=0, alpha=0, upper=math.inf, velocity=3, name="e"),
    ]
    table = DHTable(joints, "standard")
    assert table.joint_names == ("joint1", "e")
    assert_array_equal(table.lower, [-2, -math.inf])
    assert_array_equal(table.upper, [math.inf, math.inf])
    assert_array_equal(table.velocity, [math.inf, 3])
    assert table.rows == ("x", "y", "z", "wx", "wy", "wz")


def test_a_rotation_written_to_six_digits_becomes_exact_and_an_exact_one_is_kept():
    exact = screw(0, 0.3, 0.1) @ screw(1, 1.1, 0.2)
    rounded = np.round(exact, 6)
    table = DHTable([DHJoint(a=1, d=0, alpha=0)], "standard", base=rounded, tool=exact)
    assert_array_equal(rounded, np.round(exact, 6))
    rotation = table.base[:3, :3]
    assert_allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=1e-15)
    assert_allclose(rotation, exact[:3, :3], rtol=0, atol=1e-6)
    assert_array_equal(table.base[:3, 3], rounded[:3, 3])
    assert_array_equal(table.tool, exact)


# --------------------------------------------------------------------------------------------------- TOML
EXAMPLE = """
name = "arm"
convention = "modified"
angles = "deg"
rows = ["x", "wz"]
rest = [45, 0.5]

[base]
xyz = [1, 2, 3]
rpy = [10, 20, 30]

[tool]
matrix = [[0, -1, 0, 0.5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]

[[joint]]
name = "turn"
a = 0
d = 0.25
alpha = 90
theta = -45
lower = -90
upper = 180
velocity = 270

[[joint]]
type = "prismatic"
a = 0.5
d = 0
alpha = -90
theta = 30
lower = 0
upper = 2
velocity = 0.5
"""


def test_degrees_are_read_as_the_radians_of_the_standard_library():
    table = table_from_toml(EXAMPLE)
    turn, slide = table.joints
    assert turn == DHJoint(
        name="turn",
        a=0,
        d=0.25,
        alpha=math.pi / 2,
        theta=-math.pi / 4,
        lower=-math.pi / 2,
        upper=math.pi,
        velocity=1.5 * math.pi,
    )
    assert (slide.alpha, slide.theta) == (-math.pi / 2, math.radians(30))
    assert (slide.lower, slide.upper, slide.velocity) == (0, 2, 0.5)
    assert_array_equal(table.rest, [math.pi / 4, 0.5])
    assert (table.name, table.rows) == ("arm", ("x", "wz"))


@pytest.mark.parametrize("quarters", range(-8, 9))
def test_multiples_of_ninety_degrees_are_exact(quarters):
    table = table_from_toml(f"convention='standard'\nangles='deg'\njoint=[{{a=0,d=0,alpha={90 * quarters}}}]")
    assert table.joints[0].alpha == quarters * math.pi / 2


def test_rpy_is_roll_then_pitch_then_yaw_about_fixed_axes():
    table = table_from_toml(EXAMPLE)
    roll, pitch, yaw = np.radians([10, 20, 30])
    expected = screw(2, yaw, 0) @ screw(1, pitch, 0) @ screw(0, roll, 0)
    expected[:3, 3] = 1, 2, 3
    assert_allclose(table.base, expected, rtol=0, atol=1e-15)
    assert_array_equal(table.tool[:, 3], [0.5, 0, 0, 1])


def test_rows_may_be_written_as_a_list_of_inline_tables():
    listed = "convention='standard'\nangles='rad'\njoint=[{a=1,d=2,alpha=3},\n{a=4,d=5,alpha=-1,theta=2},\n]"
    headed = "convention='standard'\nangles='rad'\n[[joint]]\na=1\nd=2\nalpha=3\n[[joint]]\na=4\nd=5\nalpha=-1\ntheta=2"
    assert equal(table_from_toml(listed), table_from_toml(headed))


@family
@given(tables())
def test_a_table_written_as_toml_is_read_back_to_the_last_bit(table):
    assert equal(table_from_toml(table_to_toml(table)), table)


def test_any_printable_name_survives_the_round_trip():
    table = DHTable([DHJoint(a=0, d=0, alpha=0, name='"q\\1" é 🦾')], "standard", name="arm 'a'\\\"b\"")
    assert equal(table_from_toml(table_to_toml(table)), table)


def test_a_file_is_read_whatever_its_line_ends_and_names_the_arm_if_the_text_does_not(tmp_path):
    path = tmp_path / "elbow.toml"
    text = "convention = 'standard'\r\nangles = 'deg'\r\njoint = [{ a = 0, d = 0, alpha = 0 }]\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert read_dh(path).name == "elbow"
    assert read_dh(str(path)).n == 1


# ---------------------------------------------------------------------------------------------- bad input
NAN = float("nan")
GOOD = {"a": 0.1, "d": 0.2, "alpha": 0.3}


@pytest.mark.parametrize(
    "row, message",
    [
        ({"a": NAN}, r"^a must be a finite number of at most 1e\+06, got nan$"),
        ({"d": math.inf}, r"^d must be a finite number .* got inf$"),
        ({"alpha": "90"}, r"^alpha must be a finite number .* got '90'$"),
        ({"theta": True}, r"^theta must be a finite number .* got True$"),
        ({"a": 10**400}, r"^a must be a finite number .* got 10000"),
        ({"a": 2e6}, r"^a must be a finite number of at most 1e\+06, got 2000000\.0$"),
        ({"a": NAN, "name": "elbow"}, r"^joint 'elbow': a must be"),
        ({"lower": NAN}, r"^lower must be a finite number .* got nan$"),
        ({"lower": math.inf}, r"^lower must be a finite number .* got inf$"),
        ({"upper": [1]}, r"^upper must be a finite number .* got \[1\]$"),
        ({"lower": 1, "upper": -1}, r"^lower must be less than upper, got 1\.0 and -1\.0$"),
        ({"lower": 1, "upper": 1}, r"^lower must be less than upper, got 1\.0 and 1\.0$"),
        ({"velocity": 0}, r"^velocity must be positive, got 0\.0$"),
        ({"velocity": -2}, r"^velocity must be positive, got -2\.0$"),
        ({"kind": "helical"}, r"^type must be revolute or prismatic, got 'helical'$"),
        ({"kind": "prismatic"}, r"^a prismatic joint must state lower and upper, got None and None$"),
        ({"kind": "prismatic", "lower": 0}, r"^a prismatic joint must .* got 0\.0 and None$"),
        ({"name": "a\nb"}, r"^a joint name must be printable text, got 'a\\nb'$"),
        ({"name": 3}, r"^a joint name must be printable text, got 3$"),
    ],
)
def test_a_row_that_cannot_be_meant_is_refused(row, message):
    with pytest.raises(DHError, match=message):
        DHJoint(**{**GOOD, **row})


def stretched():
    pose = np.eye(4)
    pose[0, 0] = 1.1
    return pose


@pytest.mark.parametrize(
    "given, message",
    [
        ({"convention": "craig"}, r"^convention must be standard or modified, got 'craig'$"),
        ({"convention": None}, r"^convention must be standard or modified, got None$"),
        ({"joints": []}, r"^a DH table needs from 1 to 100 joints, got 0$"),
        ({"joints": [DHJoint(**GOOD)] * 101}, r"^a DH table needs from 1 to 100 joints, got 101$"),
        ({"joints": [[0, 0, 0, 0]]}, r"^joints must be a sequence of DHJoint, got \[\[0, 0, 0, 0\]\]$"),
        ({"joints": 3}, r"^joints must be a sequence of DHJoint, got 3$"),
        ({"joints": [DHJoint(**GOOD, name="j")] * 2}, r"^two joints are called 'j'$"),
        ({"joints": [DHJoint(**GOOD, name="joint2"), DHJoint(**GOOD)]}, r"^two joints are called 'joint2'$"),
        (
            {"joints": [DHJoint(**GOOD, name="tool")]},
            r"^a joint cannot be called 'tool': the arm has a frame",
        ),
        ({"joints": [DHJoint(**GOOD, name="universe")]}, r"^a joint cannot be called 'universe'"),
        ({"name": " "}, r"^the name of the arm must be printable text, got ' '$"),
        (
            {"rows": ["x", "roll"]},
            r"^rows must be some of x y z wx wy wz, each at most once, got \['x', 'roll'\]$",
        ),
        ({"rows": ["x", "x"]}, r"^rows must be some of .* each at most once"),
        ({"rows": []}, r"^rows must be some of .* got \[\]$"),
        ({"rows": "xyz"}, r"^rows must be some of .* got 'xyz'$"),
        ({"rows": [["x"]]}, r"^rows must be some of .* got \[\['x'\]\]$"),
        (
            {"base": stretched()},
            r"^base must be a rotation and a translation with last row 0 0 0 1, got \[\[1\.1",
        ),
        ({"tool": -np.eye(4)}, r"^tool must be a rotation and a translation"),
        ({"tool": np.diag([1, 1, -1, 1])}, r"^tool must be a rotation and a translation"),
        ({"tool": np.diag([1, 1, 1, 2])}, r"^tool must be a rotation and a translation"),
        ({"base": np.eye(3)}, r"^base must have shape \(\.\.\., 4, 4\), got \(3, 3\)$"),
        ({"base": [np.eye(4)]}, r"^base must have shape \(4, 4\), got \(1, 4, 4\)$"),
        ({"base": np.full((4, 4), NAN)}, r"^base must be finite, got NaN"),
        (
            {"base": screw(0, 0, 1e9)},
            r"^base must hold numbers of at most 1e\+06, got \[\[1\.0, 0\.0, 0\.0, 1000000000",
        ),
        ({"rest": ["0"]}, r"^rest must be an array of real numbers, got \['0'\]$"),
        ({"rest": [True]}, r"^rest must hold numbers, got \[True\]$"),
        ({"base": "here"}, r"^base must be an array of real numbers, got 'here'$"),
        ({"rest": [0, 0]}, r"^rest must have shape \(\.\.\., 1\), got \(2,\)$"),
        ({"rest": [[0]]}, r"^rest must have shape \(1,\), got \(1, 1\)$"),
        ({"rest": [NAN]}, r"^rest must be finite"),
        (
            {"joints": [DHJoint(**GOOD, lower=-1, upper=1)], "rest": [2]},
            r"^rest is 2 at joint 'joint1', outside its limits \[-1, 1\]$",
        ),
    ],
)
def test_a_table_that_cannot_be_meant_is_refused(given, message):
    with pytest.raises(DHError, match=message):
        DHTable(**{"joints": [DHJoint(**GOOD)], "convention": "standard", **given})


@pytest.mark.parametrize("method", ["pose", "frames", "jacobian"])
@pytest.mark.parametrize(
    "q, message",
    [
        ([0.0, 0.0], r"q must have shape \(\.\.\., 1\), got \(2,\)"),
        (0.0, r"q must have shape \(\.\.\., 1\), got \(\)"),
        ([NAN], "q must be finite"),
        (["one"], "q must be an array of real numbers"),
    ],
)
def test_a_q_that_cannot_be_meant_is_refused(method, q, message):
    table = DHTable([DHJoint(**GOOD)], "standard")
    with pytest.raises(InputError, match=message):
        getattr(table, method)(q)


HEAD = "convention = 'standard'\nangles = 'deg'\n"
ROW = "joint = [{ a = 0, d = 0, alpha = 0 }]\n"


@pytest.mark.parametrize(
    "text, message",
    [
        ("convention = \n", r"^DH text: not valid TOML: .*line 1, column 14"),
        ("joint = [\n{ a = 1,, }]", r"^DH text: not valid TOML: .*line 2, column"),
        ("x = " + "[\n" * 5000, r"^DH text: not valid TOML: nested too deeply$"),
        ("a." * 10_000 + "c = 1", r"^DH text: it has a line of over 2000 characters$"),
        ("", r"^DH text: the table has no 'convention'; it must state convention, angles, joint$"),
        ("convention = 'standard'\n" + ROW, r"^DH text: the table has no 'angles'"),
        (HEAD, r"^DH text: the table has no 'joint'"),
        (
            HEAD + ROW + "jiont = 1",
            r"the table has an unknown key 'jiont'; did you mean 'joint'\? there are: angles, base",
        ),
        (HEAD + "joint = []", r"a DH table needs from 1 to 100 joints, got 0"),
        (HEAD + "joint = 3", r"joint must be a list of tables, \[\[joint\]\], got 3"),
        (HEAD + "[joint]\na = 0", r"joint must be a list of tables, \[\[joint\]\], got \{'a': 0\}"),
        (HEAD + "joint = [[0, 0, 0, 0]]", r"joint1 must be a table with a, d and alpha, got \[0, 0, 0, 0\]"),
        (HEAD + "joint = [{ a = 0, d = 0 }]", r"joint 'joint1' has no 'alpha'; it must state a, d, alpha"),
        (
            HEAD + "joint = [{ a = 0, d = 0, apha = 0 }]",
            r"joint 'joint1' has an unknown key 'apha'; did you mean 'alpha'",
        ),
        (
            HEAD + "joint = [{ a = 0, d = nan, alpha = 0 }]",
            r"joint 'joint1': d must be a finite number .* got nan",
        ),
        (HEAD + "joint = [{ a = 0, d = 0, alpha = '90' }]", r"joint 'joint1': alpha must be .* got '90'"),
        (HEAD + "joint = [{ a = 0, d = 0, alpha = 0, kind = 'prismatic' }]", r"unknown key 'kind'; .*type"),
        (
            HEAD + "joint = [{ a = 0, d = 0, alpha = 0, lower = 90, upper = -90 }]",
            r"joint 'joint1': lower must be less than upper, got 90\.0 and -90\.0",
        ),
        (
            HEAD + "rest = [200]\njoint = [{ a = 0, d = 0, alpha = 0, lower = -170, upper = 170 }]",
            r"rest is 200 at joint 'joint1', outside its limits \[-170, 170\]",
        ),
        (
            HEAD + ROW + "[base]\nxzy = [0, 0, 0]",
            r"base has an unknown key 'xzy'; did you mean 'xyz'\? there are: matrix, rpy, xyz",
        ),
        (HEAD + ROW + "[tool]\nxyz = [0, 0]", r"tool\.xyz must have shape \(\.\.\., 3\), got \(2,\)"),
        (HEAD + ROW + "[tool]\nrpy = [0, nan, 0]", r"tool\.rpy must be finite"),
        (HEAD + ROW + "[tool]\nmatrix = [[1]]", r"tool must have shape \(\.\.\., 4, 4\), got \(1, 1\)"),
        (
            HEAD + ROW + "[tool]\nmatrix = [[1]]\nxyz = [0, 0, 0]",
            r"tool has matrix and also xyz or rpy; give one of them",
        ),
        (HEAD + ROW + "base = 1", r"base must be a table with xyz and rpy, or matrix, got 1"),
        (HEAD.replace("deg", "grad") + ROW, r"angles must be 'deg' or 'rad', got 'grad'"),
        (HEAD.replace("standard", "distal") + ROW, r"convention must be standard or modified, got 'distal'"),
        (HEAD + ROW + "#" * MAX_BYTES, rf"it has \d+ characters; a DH table of over {MAX_BYTES} is refused"),
    ],
)
def test_text_that_cannot_be_meant_is_refused_with_its_source(text, message):
    with pytest.raises(DHError, match=message) as caught:
        table_from_toml(text)
    assert str(caught.value).startswith("DH text: ")


VALUES = st.recursive(
    st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=8,
)


@settings(family, max_examples=120)
@given(st.sampled_from(["convention", "angles", "rows", "rest", "joint", "base", "tool", "name"]), VALUES)
def test_any_value_under_any_key_gives_a_table_or_a_dh_error(key, value):
    entries = {"convention": '"standard"', "angles": '"deg"', "joint": "[{ a = 0, d = 0, alpha = 0 }]"}
    entries[key] = json.dumps(value, ensure_ascii=False).replace("\x7f", "")
    try:
        table = table_from_toml("\n".join(f"{name} = {text}" for name, text in entries.items()))
    except DHError:
        return
    assert table.pose([0.0]).shape == (4, 4)


@settings(family, max_examples=120)
@given(st.sampled_from(["a", "d", "alpha", "theta", "type", "lower", "upper", "velocity", "name"]), VALUES)
def test_any_value_in_a_row_gives_a_table_or_a_dh_error(key, value):
    row = {"a": "0", "d": "0", "alpha": "0"}
    row[key] = json.dumps(value, ensure_ascii=False).replace("\x7f", "")
    entry = ", ".join(f"{name} = {text}" for name, text in row.items())
    try:
        table = table_from_toml(HEAD + f"joint = [{{ {entry} }}]")
    except DHError:
        return
    assert table.pose([0.0]).shape == (4, 4)


def test_a_file_that_cannot_be_meant_is_refused_with_its_path(tmp_path):
    with pytest.raises(RobotNotFoundError, match=r"there is no file '.*none\.toml'"):
        read_dh(tmp_path / "none.toml")
    with pytest.raises(RobotNotFoundError, match="there is no file"):
        read_dh(tmp_path)
    path = tmp_path / "arm.toml"
    path.write_bytes(b"name = '\xff'")
    with pytest.raises(DHError, match=r"arm\.toml: not UTF-8 text: invalid start byte at byte 8"):
        read_dh(path)
    path.write_text("convention =\n")
    with pytest.raises(DHError, match=r"arm\.toml: not valid TOML: .*line 1"):
        read_dh(path)
    path.write_bytes(b"#" * (MAX_BYTES + 1))
    with pytest.raises(LoadError, match=rf"has {MAX_BYTES + 1} bytes; a file of over {MAX_BYTES} is refused"):
        read_dh(path)


@pytest.mark.parametrize("key", ["alpha", "theta"])
def test_radians_that_seem_degrees_are_asked_about(key):
    row = {"a": 0, "d": 0, "alpha": 0} | {key: 90}
    entry = ", ".join(f"{name} = {value}" for name, value in row.items())
    with pytest.raises(DHError, match=f"{key} = 90 rad, over two turns: is 'deg' meant|over two turns"):
        table_from_toml(f"convention = 'standard'\nangles = 'rad'\njoint = [{{ {entry} }}]")
