"""Why an arm stands still, and what is the way on."""

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.limits import HalfSpace, Obstacle

PANDA = rik.load("panda")


def stopped(controller, stack, q, steps=600):
    for _ in range(steps):
        step = controller.step(q, stack, 0.02)
        q = controller.robot.integrate(q, 0.02 * step.qdot)
    return q, step


def test_a_joint_at_its_end_is_named_and_the_target_is_found_to_be_reachable():
    beyond = PANDA.rest.copy()
    beyond[3] = PANDA.upper[3] + 0.3
    q = PANDA.rest.copy()
    q[3] = PANDA.upper[3] - 1e-6
    stack = [[rik.FrameTask(PANDA.pose(beyond), gain=2.0, max_linear=0.1, max_angular=0.3)]]
    found = rik.why_stuck(rik.VelocityController(PANDA), q, stack)
    assert found.held == ("panda_joint4 position",)
    assert len(found.saturated) == 6
    assert found.reachable
    assert "The target can be reached, from another side" in str(found)
    np.testing.assert_allclose(PANDA.pose(found.nearest.q), PANDA.pose(beyond), atol=1e-6)
    assert ((found.nearest.q >= PANDA.lower) & (found.nearest.q <= PANDA.upper)).all()
    assert str(found).startswith("Held by panda_joint4 position.")


def test_a_target_out_of_reach_is_told_with_its_distance_and_what_is_lost():
    target = PANDA.pose(PANDA.rest).copy()
    target[:3, 3] *= 3.0 / np.linalg.norm(target[:3, 3])
    controller = rik.VelocityController(PANDA)
    stack = [[rik.FrameTask(target, gain=2.0, max_linear=0.1, max_angular=0.3)]]
    q, _ = stopped(controller, stack, PANDA.rest)
    found = rik.why_stuck(controller, q, stack)
    assert found.reachable is False
    assert found.lost is not None
    assert found.asked > 0.5
    miss = np.linalg.norm(PANDA.pose(found.nearest.q)[:3, 3] - target[:3, 3])
    np.testing.assert_allclose(found.nearest.error[0], miss, rtol=1e-6)
    assert f"out of reach by {1e3 * miss:.3g} mm" in str(found)
    assert "can hardly move the tool along" in str(found)


def test_a_table_in_the_way_is_named():
    floor = Obstacle("table", HalfSpace((0.0, 0.0, 1.0), 0.2))
    near = rik.CollisionLimit.of(PANDA, obstacles=[floor])
    controller = rik.VelocityController(PANDA, limits=[rik.JointLimits.of(PANDA), near])
    target = PANDA.pose(PANDA.rest).copy()
    target[2, 3] = 0.0
    stack = [[rik.FrameTask(target, gain=2.0, max_linear=0.1)]]
    q, _ = stopped(controller, stack, PANDA.rest, 200)
    assert any("table" in each for each in rik.why_stuck(controller, q, stack).held)


def test_where_nothing_holds_the_arm_it_says_so_and_other_tasks_have_no_pose():
    controller = rik.VelocityController(PANDA)
    found = rik.why_stuck(controller, PANDA.rest, [[rik.PostureTask(PANDA.rest + 0.1)]])
    assert found.held == ()
    assert found.lost is None
    assert found.reachable is None
    assert str(found) == "No limit holds it."


@pytest.mark.parametrize("changes", [{"controller": None}, {"q": np.zeros(3)}, {"q": None}, {"stack": None}])
def test_what_cannot_be_meant_is_refused(changes):
    given = {"controller": rik.VelocityController(PANDA), "q": PANDA.rest, "stack": [[rik.PostureTask(PANDA.rest)]]}
    with pytest.raises(rik.RobustIKError):
        rik.why_stuck(**given | changes)
