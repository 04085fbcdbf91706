"""`robust-ik path`, as its user sees it."""

import numpy as np

import robust_ik as rik
from tests.cli.test_cli import command  # noqa: F401 (a fixture)


def write(path, T):
    rows = [[*M[:3, 3], *M[:3, :3].ravel()] for M in T]
    lines = ["x,y,z,roll,pitch,yaw"]
    for x, y, z, *R in rows:
        turn = np.arctan2(R[7], R[8]), np.arcsin(-R[6]), np.arctan2(R[3], R[0])
        lines.append(",".join(repr(float(value)) for value in (x, y, z, *turn)))
    path.write_text("\n".join(lines))


def test_a_path_that_is_followed_is_written(command, tmp_path):  # noqa: F811
    robot = rik.load("ur5")
    q = np.array([0.3, -1.2, 1.1, -0.4, 1.2, 0.1])
    poses = robot.pose(q + np.linspace(0, 0.5, 20)[:, None] * np.array([1, 0.3, -0.4, 0.2, 0.3, 1]))
    write(tmp_path / "poses.csv", poses)
    status, out, _ = command("path", "ur5", "poses.csv", "-o", "joints.csv")
    assert status == 0
    assert "One motion follows the whole path." in out
    found = np.genfromtxt(tmp_path / "joints.csv", delimiter=",", names=True)
    assert found.dtype.names[:3] == ("piece", "s", "shoulder_pan_joint")
    values = np.array([list(each)[2:] for each in found])
    assert np.abs(robot.pose(values[-1]) - poses[-1]).max() < 1e-6


def test_a_path_that_leaves_the_reach_has_status_2_and_a_reason(command, tmp_path):  # noqa: F811
    robot = rik.load("ur5")
    T = robot.pose([0.3, -1.2, 1.1, -0.4, 1.2, 0.1])
    far = T.copy()
    far[:3, 3] += [0.9, 0, 0]
    write(tmp_path / "poses.csv", [T, far])
    status, out, _ = command("path", "ur5", "poses.csv", "--accuracy", "1e-3")
    assert status == 2
    assert "until 1" in out
    assert "no configuration reaches the path" in out
    status, _, err = command("path", "ur5", "poses.csv", "--longest-step", "0.5")
    assert status == 1
    assert "line 3: the position is 0.9 m from the one before" in err
