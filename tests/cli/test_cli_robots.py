"""What commands say of how a robot was read, and how they take arguments of xacro files."""

import sys
from pathlib import Path

import pytest

import robust_ik as rik
from robust_ik import cli
from robust_ik.cli.shared import xacro_arguments
from robust_ik.runtime import warn_once

DATA = Path(__file__).parents[1] / "data"


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Runs the command: exit status, standard output, standard error."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli.console, "width", 200)
    monkeypatch.setattr(cli.errors, "width", 200)
    monkeypatch.setattr(warn_once, "_TOLD", set())

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["robust-ik", *arguments])
        with pytest.raises(SystemExit) as stop:
            cli.main()
        captured = capsys.readouterr()
        return stop.value.code, captured.out, captured.err

    return run


def test_info_lists_the_notes_and_says_them_once(command):
    status, out, err = command("info", str(DATA / "zero_zero_limits.urdf"))
    assert status == 0
    assert "joint 'a_j1': has position limits 0 and 0" in out
    assert "note:" not in err


def test_info_says_which_tip_was_guessed(command):
    from robust_ik.description.catalog import catalog

    _, out, _ = command("info", str(catalog()["panda"].path))
    assert "no tip was given: 'panda_hand', the last link that the fingers share" in " ".join(out.split())


def test_many_notes_are_cut(command, tmp_path):
    path = tmp_path / "a.urdf"
    text = (DATA / "scara.urdf").read_text()
    path.write_text(text.replace("</robot>", "".join(f"<p{i}:q/>" for i in range(9)) + "</robot>"))
    _, out, _ = command("info", str(path))
    assert "(9 in all)" in out


def test_other_commands_print_the_notes_beside_what_they_print(command):
    status, out, err = command("export", str(DATA / "colour_of_three.urdf"), "out.urdf")
    assert status == 0
    assert "note: " in err
    assert "a colour of 3 numbers is read as 1 0 0 1" in err
    assert "note:" not in out
    assert rik.load("out.urdf").notes == ()


def test_a_tip_error_offers_hands(command):
    from robust_ik.description.catalog import catalog

    status, _, err = command("info", str(catalog()["tiago_dual"].path))
    assert status == 1
    assert "one of: hand_left_palm_link, hand_right_palm_link; or torso_lift_link" in err


@pytest.mark.parametrize("form", ["kind:=continuous", "kind=continuous"])
def test_arguments_of_xacro_are_given_by_name(command, tmp_path, form):
    pytest.importorskip("xacrodoc")
    (tmp_path / "arm.xacro").write_text(
        '<robot name="arm" xmlns:xacro="http://x"><xacro:arg name="kind" default="fixed"/>'
        '<link name="a"/><link name="b"/>'
        '<joint name="j" type="$(arg kind)"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>'
    )
    assert command("info", "arm.xacro")[0] == 1
    status, out, _ = command("info", "arm.xacro", "--xacro-arg", form)
    assert status == 0
    assert "1 independent" in out


def test_arguments_of_xacro_that_name_nothing_are_refused(command):
    assert xacro_arguments(["a:=b=c", "d=", "e:=1"]) == {"a": "b=c", "d": "", "e": "1"}
    for wrong in ("a", "=b", ":=b"):
        status, _, err = command("info", "panda", "--xacro-arg", wrong)
        assert status == 1
        assert "--xacro-arg takes NAME:=VALUE" in err


def test_any_command_puts_a_robot_on_a_base_that_moves(command, tmp_path):
    out = command("info", "ur5", "--base", "planar")[1]
    assert all(name in out for name in ("9 independent", "base_x", "base_y", "base_yaw"))
    out = command("singularities", "ur5", "--base", "floating")[1]
    assert "none within the limits; base_x to base_roll alone move the tip" in " ".join(out.split())
    status, _, err = command("info", "ur5", "--base", "omni")
    assert (status, "base must be 'fixed', 'planar' or 'floating', got 'omni'" in err) == (1, True)


def test_a_robot_that_is_exported_on_its_base_is_read_as_the_same_robot(command):
    assert command("export", "puma560", "out.urdf", "--base", "floating")[0] == 0
    again, robot = rik.load("out.urdf"), rik.load("puma560", base="floating")
    assert again.joint_names == robot.joint_names
    assert (again.lower[:6] == robot.lower[:6]).all()
    assert abs(again.pose(again.neutral) - robot.pose(robot.neutral)).max() < 1e-12
