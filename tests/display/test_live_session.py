"""What a live page is told of a configuration, and what its commands do, over arms of many kinds."""

import json

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.display.live.live_commands import FIELDS, LONGEST, LiveCommand, read_command
from robust_ik.display.live.live_session import FILTERS, LiveSession
from robust_ik.display.live.live_state import LiveState, threshold
from robust_ik.display.live.self_motion_steps import LONGEST as LONGEST_STEP
from robust_ik.display.live.self_motion_steps import parts
from robust_ik.display.live.waiting_commands import MOST_WAITING, WaitingCommands
from robust_ik.errors import InputError

ARMS = ("panda", "ur5", "puma560", "so101", "planar_3r", "kinova_gen3")


@pytest.fixture(scope="module", params=ARMS)
def robot(request):
    return rik.load(request.param)


def do(session, command, **values):
    session.do(LiveCommand(command, values))
    return session.said


# ---------------------------------------------------------------------------------------- the state
def test_the_state_is_that_of_the_robot(robot):
    for q in robot.random(np.random.default_rng(3), 5):
        state = LiveState.of(robot, q, rik.JParse(0.2))
        s = rik.svd(robot.jacobian(q)).s
        assert np.allclose(state.sigma, s)
        assert np.allclose(state.shares, np.minimum(1.0, (s / (0.2 * s[0])) ** 2), atol=1e-9)
        assert state.threshold == pytest.approx(0.2 * s[0], rel=1e-6)
        assert state.manipulability == pytest.approx(np.prod(s))
        assert state.corank == 0
        assert state.still == robot.n - len(s)
        assert len(state.weak) == np.sum(s < 0.2 * s[0] * np.sqrt(0.995))
        assert (state.room >= 0).all()
        assert np.allclose(state.position, robot.pose(q)[:3, 3])
        json.dumps(state.plain(), allow_nan=False)


def test_a_joint_at_its_limit_has_no_room_and_one_without_limits_has_all_of_it():
    robot = rik.load("panda")
    values = np.array(robot.joint_values(robot.rest))
    values[3] = robot.upper[3]
    assert LiveState.of(robot, robot.configuration(values), rik.JParse()).room[3] == pytest.approx(0.0)
    unlimited = rik.load("planar_3r")
    where = ~np.isfinite(unlimited.upper)
    assert (LiveState.of(unlimited, unlimited.rest, rik.JParse()).room[where] == 1.0).all()


def test_where_rank_is_lost_the_state_says_so():
    robot = rik.load("puma560")
    q = robot.configuration(np.array([0.3, -0.5, 0.9, 0.4, 0.0, 0.2]))
    state = LiveState.of(robot, q, rik.MoorePenrose())
    assert (state.corank, state.still, state.condition) == (1, 1, np.inf)
    assert [sigma < 1e-9 for sigma, _ in state.weak] == [True]
    assert state.plain()["condition"] is None
    nearby = LiveState.of(robot, robot.configuration(np.array([0.3, -0.5, 0.9, 0.4, 0.3, 0.2])), rik.MoorePenrose())
    assert (nearby.corank, nearby.still, nearby.weak) == (0, 0, ())


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_thresholds_are_where_inverses_begin_to_be_exact(name):
    inverse = FILTERS[name]()
    for largest in (0.5, 2.0):
        found = threshold(inverse, largest)
        if found is None:
            assert not inverse.is_exact(np.array([largest, largest]))[1]
            continue
        assert inverse.is_exact(np.array([largest, found + 1e-9 * largest]))[1]
        if found > 0:
            assert not inverse.is_exact(np.array([largest, found - 1e-11 * largest]))[1]


# ---------------------------------------------------------------------------------------- commands
def test_a_joint_goes_where_it_is_sent_and_no_farther_than_its_limits(robot):
    session = LiveSession(robot, robot.rest)
    middle = np.clip(0.0, robot.lower[0], robot.upper[0]) + 0.1
    assert do(session, "joint", index=0, value=float(middle)) == ""
    assert robot.joint_values(session.q)[0] == pytest.approx(middle)
    do(session, "joint", index=0, value=1e5)
    assert robot.joint_values(session.q)[0] <= robot.upper[0]
    before = session.q
    assert "got number 41" in do(session, "joint", index=40, value=0.0)
    assert np.array_equal(session.q, before)
    do(session, "rest")
    assert np.array_equal(session.q, robot.rest)


def test_the_tool_follows_its_target_and_says_how_far_it_is_if_it_cannot(robot):
    session = LiveSession(robot, robot.rest)
    near = robot.pose(
        robot.configuration(robot.joint_values(robot.rest) * 0.9 + 0.05 * np.clip(0, robot.lower, robot.upper))
    )
    wanted = session.kept.copy()
    wanted[:3, 3] = near[:3, 3]
    said = do(session, "position", values=near[:3, 3].tolist())
    error = np.linalg.norm(robot.pose(session.q)[:3, 3] - near[:3, 3])
    assert (said == "") == robot.solve_pose(wanted, robot.rest).solved
    if said == "" and {"x", "y", "z"} <= set(robot.rows):
        assert error < 1e-5
    far = [100.0 * robot.size, 0.0, 0.0]
    assert "mm" in do(session, "position", values=far)
    assert np.allclose(session.kept[:3, 3], far)
    assert "three values" in do(session, "position", values=[1.0])


@pytest.mark.parametrize("name", ["panda", "kinova_gen3", "xarm7", "puma560"])
def test_self_motions_leave_the_tool_where_it_is_and_move_the_arm(name):
    robot = rik.load(name)
    q = robot.rest
    if name == "puma560":
        q = robot.configuration(np.array([0.3, -0.5, 0.9, 0.4, 0.0, 0.2]))  # its wrist is straight
    session = LiveSession(robot, q)
    T = robot.pose(q)
    for by in (0.04, 0.04, 0.3, -0.2):
        before = session.q
        assert do(session, "self_motion", index=0, by=by) == ""
        assert np.abs(robot.pose(session.q) - T).max() < 1e-5
        moved = np.linalg.norm(robot.difference(before, session.q))
        assert 0.3 * abs(by) < moved < 1.5 * abs(by)
    assert "self-motions here" in do(session, "self_motion", index=3, by=0.1)


def test_going_on_along_a_self_motion_goes_on():
    robot = rik.load("panda")
    session = LiveSession(robot, robot.rest)
    places = [robot.joint_values(session.q)]
    for _ in range(8):
        do(session, "self_motion", index=0, by=0.05)
        places.append(robot.joint_values(session.q))
    steps = np.diff(places, axis=0)
    assert (np.sum(steps[1:] * steps[:-1], axis=1) > 0).all()


def test_an_arm_without_self_motion_says_so():
    robot = rik.load("ur5")
    session = LiveSession(robot, robot.rest)
    assert "0 self-motions" in do(session, "self_motion", index=0, by=0.1)
    assert np.array_equal(session.q, robot.rest)


def test_families_are_gone_to_within_limits_or_refused():
    robot = rik.load("panda")
    session = LiveSession(robot, robot.rest)
    assert "not known yet" in do(session, "family", index=0)
    session.atlas = rik.find_singularities(robot, 1, starts=400, certify=False)
    inside = [place for place, row in enumerate(session.atlas.strata) if row.within_limits]
    assert inside
    for place, row in enumerate(session.atlas.strata):
        do(session, "rest")
        said = do(session, "family", index=place)
        assert (said == "") == row.within_limits
        if not said:
            values = robot.joint_values(session.q)
            assert (values >= robot.lower - 1e-9).all()
            assert (values <= robot.upper + 1e-9).all()
            assert session.state.sigma[-1] < 1e-5
            near = session.nearby()
            assert near.distance < 1e-5
        else:
            assert np.array_equal(session.q, robot.rest)
    assert "families, got number" in do(session, "family", index=99)


def test_all_solutions_reach_the_pose_and_one_can_be_chosen():
    robot = rik.load("ur5")
    session = LiveSession(robot, robot.rest)
    T = robot.pose(robot.rest)
    assert "ask for all" in do(session, "solution", index=0)
    assert do(session, "solutions") == ""
    assert len(session.solutions.q) > 1
    for index in range(len(session.solutions.q)):
        assert do(session, "solution", index=index) == ""
        assert np.abs(robot.pose(session.q) - T).max() < 1e-8
    do(session, "joint", index=0, value=0.3)
    assert session.solutions is None


def test_inverses_are_chosen_with_their_parameters_and_bad_ones_change_nothing():
    session = LiveSession(rik.load("ur5"), rik.load("ur5").rest)
    assert do(session, "inverse", name="JParse", parameters={"gamma": 0.3}) == ""
    assert session.inverse == rik.JParse(0.3)
    for name, parameters in (("None", {}), ("JParse", {"gamma": 3.0}), ("JParse", {"delta": 0.1})):
        assert do(session, "inverse", name=name, parameters=parameters)
        assert session.inverse == rik.JParse(0.3)


def test_a_robot_without_a_tip_is_refused():
    robot = rik.load("baxter", whole_tree=True)
    with pytest.raises(InputError, match="no tip"):
        LiveSession(robot, robot.rest)


# ---------------------------------------------------------------------------------------- messages
def test_every_command_is_read_as_it_is_sent():
    samples = {int: 1, float: 0.5, list: [0.1, 2], str: "JParse", dict: {"gamma": 0.1}}
    for name, fields in FIELDS.items():
        values = {key: samples[kind] for key, kind in fields.items()}
        found = read_command(json.dumps({"do": name, **values}))
        assert (found.do, dict(found.values)) == (name, values)


@pytest.mark.parametrize(
    "text",
    [
        "", "null", "[]", "{}", "1", '{"do": 1}', '{"do": "look"}', '{"do": "quit"}', '{"do": "__init__"}',
        '{"do": "joint"}', '{"do": "joint", "index": 0, "value": 1, "more": 2}',
        '{"do": "joint", "index": -1, "value": 0}',
        '{"do": "joint", "index": true, "value": 0}', '{"do": "joint", "index": 0.5, "value": 0}',
        '{"do": "joint", "index": 0, "value": NaN}', '{"do": "joint", "index": 0, "value": 1e999}',
        '{"do": "joint", "index": 0, "value": "1"}', '{"do": "joint", "index": 0, "value": 1e9}',
        '{"do": "position", "values": [[1]]}', '{"do": "inverse", "name": 3, "parameters": {}}',
        '{"do": "inverse", "name": "JParse", "parameters": {"gamma": null}}', "[" * 3000,
        b"\xff\xfe", "x" * (LONGEST + 1),
    ],
)  # fmt: skip
def test_what_is_no_command_is_refused(text):
    with pytest.raises(InputError):
        read_command(text)


def test_what_waits_is_replaced_by_newer_values_and_never_grows():
    waiting = WaitingCommands()
    for value in range(1000):
        assert waiting.put(LiveCommand("joint", {"index": 0, "value": float(value)}))
    assert waiting.take().values["value"] == 999.0
    assert waiting.empty
    kept = [waiting.put(LiveCommand("self_motion", {"index": 0, "by": 0.1})) for _ in range(MOST_WAITING + 5)]
    assert kept == [True] * MOST_WAITING + [False] * 5
    waiting.close()
    assert waiting.take() is None


def test_a_long_way_is_made_in_short_steps():
    for by in (0.0, 0.01, -0.3, 100.0):
        steps = parts(by)
        assert max(map(abs, steps)) <= LONGEST_STEP * (1 + 1e-12)
        assert sum(steps) == pytest.approx(np.clip(by, -2 * np.pi, 2 * np.pi))
