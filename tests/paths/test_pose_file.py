"""Poses of a file: read as they are, and each mistake is told with its line."""

import numpy as np
import pinocchio as pin
import pytest

import robust_ik as rik
from robust_ik.paths import pose_file


def written(tmp_path, text):
    path = tmp_path / "poses.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("mark", [",", ";", "\t", "  "])
def test_quaternions_and_angles_are_read_as_pinocchio_reads_them(mark, tmp_path, rng):
    lines, poses = [], []
    for _ in range(20):
        p, q = rng.uniform(-0.3, 0.3, 3), pin.Quaternion(pin.exp3(rng.uniform(-3, 3, 3)))
        sign = rng.choice([-1.0, 1.0])
        lines.append(mark.join(repr(float(x)) for x in (*p, *(sign * q.coeffs()), 7.0)))
        poses.append(pin.SE3(q, p).homogeneous)
    names = mark.join(("X", "y", "z", "qx", "qy", "qz", "qw", "time"))
    found = rik.read_poses(written(tmp_path, "# a comment\n" + names + "\n" + "\n\n".join(lines) + "\n"))
    np.testing.assert_allclose(found, poses, atol=1e-14)
    angles = rng.uniform(-1.5, 1.5, (5, 3))
    rows = [mark.join(map(repr, (1.0, 2.0, 3.0, *map(float, each)))) for each in angles]
    names = mark.join(("x", "y", "z", "roll", "pitch", "yaw"))
    found = rik.read_poses(written(tmp_path, names + "\n" + "\n".join(rows)), unit="mm")
    np.testing.assert_allclose(found[:, :3, :3], [pin.rpy.rpyToMatrix(*each) for each in angles], atol=1e-14)
    np.testing.assert_allclose(found[:, :3, 3], [[1e-3, 2e-3, 3e-3]] * 5)


def test_positions_alone_are_positions(tmp_path):
    found = rik.read_poses(written(tmp_path, "x,y,z\n0.1,0.2,0.3 # here\n0.1,0.2,0.4\n"))
    np.testing.assert_array_equal(found, [[0.1, 0.2, 0.3], [0.1, 0.2, 0.4]])
    robot = rik.load("ur5")
    assert robot.plan_path(found + [0.3, 0, 0]).followed


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x,y,qx\n1,2,3\n", "line 1: no column z among x, y, qx"),
        ("x,y,z,qx,qy,qz\n1,2,3,0,0,0\n", "line 1: no column qw"),
        ("x,y,z,roll\n1,2,3,0\n", "line 1: no column pitch yaw"),
        ("x,y,z,x\n1,2,3,0\n", "line 1: column x is named twice"),
        ("x,y,z\n0,0,0\n0,0\n", "line 3: 2 values, 3 columns are named in line 1"),
        ("x,y,z\n0,0,0\n0,nan,0\n", "line 3: y must be finite, got nan"),
        ("x,y,z\n0,0,zero\n", "line 2: z must be a number, got 'zero'"),
        (
            "# nothing\nx,y,z\n0,0,0\n\n0,0,3\n",
            "line 5: the position is 3 m from the one before, more than 1 m; if lengths",
        ),
        ("x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,1\n0,0,0,0,0,0,0\n", "line 3: the quaternion has length 0, not 1"),
        ("x,y,z\n", "has no poses"),
        ("", "has no poses"),
    ],
)
def test_a_mistake_is_told_with_its_line(text, said, tmp_path):
    with pytest.raises(rik.InputError, match=said):
        rik.read_poses(written(tmp_path, text))


def test_a_file_that_is_too_large_or_missing_is_refused(tmp_path, monkeypatch):
    with pytest.raises(rik.RobustIKError, match="there is no file"):
        rik.read_poses(tmp_path / "none.csv")
    path = written(tmp_path, "x,y,z\n" + "0,0,0\n" * 30)
    monkeypatch.setattr(pose_file, "MOST_POSES", 29)
    with pytest.raises(rik.InputError, match="30 poses, at most 29"):
        rik.read_poses(path)
    monkeypatch.setattr(pose_file, "MOST_BYTES", 10)
    with pytest.raises(rik.RobustIKError, match="refused"):
        rik.read_poses(path)
    with pytest.raises(rik.InputError, match="unit must be m or mm"):
        rik.read_poses(path, unit="cm")
    monkeypatch.undo()
    binary = tmp_path / "binary.csv"
    binary.write_bytes(bytes(range(256)) * 4)
    with pytest.raises(rik.InputError):
        rik.read_poses(binary)
