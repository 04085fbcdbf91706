"""Where results are written: links, pipes, devices, permissions, folders; and what is said beforehand."""

import io
import logging
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from robust_ik.display.figures.figure_files import save_figure
from robust_ik.errors import InputError
from robust_ik.runtime.output_files import check_output, check_outputs, write_file

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links, pipes and modes of Unix")


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def litter(folder):
    return [path.name for path in folder.iterdir() if path.name.endswith(".part")]


def test_a_file_is_replaced_in_one_step_and_keeps_its_rights(tmp_path):
    path = tmp_path / "secret.json"
    path.write_text("old")
    path.chmod(0o600)
    with path.open() as reader:
        assert write_file(path, "new") == path
        assert reader.read() == "old"
    assert (path.read_text(), mode(path)) == ("new", 0o600)
    assert [each.name for each in tmp_path.iterdir()] == ["secret.json"]


@pytest.mark.parametrize("umask, expected", [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_a_new_file_has_the_rights_that_the_user_gives_new_files(tmp_path, umask, expected):
    before = os.umask(umask)
    try:
        write_file(tmp_path / "new", "text")
    finally:
        os.umask(before)
    assert mode(tmp_path / "new") == expected


@pytest.mark.skipif(os.name == "nt" or os.geteuid() != 0, reason="only root can give files away")
def test_a_file_keeps_its_owner(tmp_path):
    path = tmp_path / "theirs"
    path.touch()
    os.chown(path, 12345, 12345)
    write_file(path, "text")
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 12345)


@pytest.mark.parametrize("there", [True, False], ids=["to a file", "to nothing yet"])
def test_a_link_stays_and_the_file_that_it_leads_to_is_written(tmp_path, there):
    folder = tmp_path / "folder"
    folder.mkdir()
    link, target = tmp_path / "link", folder / "target"
    if there:
        target.write_text("old")
    link.symlink_to("folder/target")
    write_file(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert not litter(tmp_path) + litter(folder)


def test_links_in_a_circle_are_refused(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(InputError, match="nothing can be written to .*symbolic links"):
        check_output(tmp_path / "a")


def test_a_pipe_is_written_to_and_stays_a_pipe(tmp_path):
    path, read = tmp_path / "pipe", []
    os.mkfifo(path)
    check_output(path)  # does not wait for a reader
    reader = threading.Thread(target=lambda: read.append(path.read_text()))
    reader.start()
    write_file(path, "through")
    reader.join(10)
    assert read == ["through"]
    assert stat.S_ISFIFO(path.stat().st_mode)


@pytest.fixture
def device(tmp_path):
    """A copy of /dev/null."""
    path = tmp_path / "null"
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, Path("/dev/null").stat().st_rdev)
        path.write_text("")
    except OSError:
        pytest.skip("devices can be made by root only, and not everywhere")
    return path


@pytest.mark.parametrize("by_link", [False, True])
def test_a_device_is_written_to_and_stays_a_device(tmp_path, device, by_link):
    path = device
    if by_link:
        path = tmp_path / "link"
        path.symlink_to(device)
    write_file(path, "nothing")
    assert stat.S_ISCHR(device.stat().st_mode)
    assert path.is_symlink() == by_link


def test_a_full_device_is_said_to_be_full():
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)
    assert not check_output("/dev/full").replaced
    with pytest.raises(InputError, match="could not be written: No space left on device"):
        write_file("/dev/full", "text")
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)


PROGRAM = """
import sys
from robust_ik.runtime.output_files import write_file
print("before")
write_file(sys.argv[1], "result\\n")
print("after")
"""


@pytest.mark.parametrize("name", ["/dev/stdout", "-", "/dev/fd/1", "/proc/self/fd/1"])
@pytest.mark.parametrize("to_file", [True, False])
def test_standard_output_is_written_to_in_its_turn_wherever_it_goes(tmp_path, name, to_file):
    command = [sys.executable, "-c", PROGRAM, name]
    if to_file:
        with (tmp_path / "out").open("w") as out:
            subprocess.run(command, stdout=out, check=True, timeout=60)
        text = (tmp_path / "out").read_text()
    else:
        text = subprocess.run(command, stdout=subprocess.PIPE, check=True, timeout=60, text=True).stdout
    assert text.split() == ["before", "result", "after"]


def test_one_missing_folder_is_made_and_told_more_are_refused(tmp_path, caplog):
    with caplog.at_level(logging.INFO, "robust_ik"):
        write_file(tmp_path / "out" / "x", "text")
    assert "made the folder" in caplog.text
    with pytest.raises(InputError, match="there is no folder '.*/no' to write .*: make it first"):
        check_output(tmp_path / "no" / "such" / "x")
    assert not (tmp_path / "no").exists()


@pytest.mark.parametrize("path", ["/proc/x.html", "/proc/self/x.html", "/sys/x.html"])
def test_where_nothing_can_be_written_is_said_beforehand(path):
    if not Path("/proc/self").is_dir():
        pytest.skip("there is no /proc")
    with pytest.raises(InputError, match="nothing can be written in the folder '/"):
        check_output(path)


def test_looking_leaves_nothing_behind(tmp_path):
    check_output(tmp_path / "x")
    check_output(tmp_path / "folder" / "x")
    (tmp_path / "there").write_text("as it was")
    check_output(tmp_path / "there")
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    assert (tmp_path / "there").read_text() == "as it was"


@pytest.mark.parametrize(
    "path, words",
    [
        (".", "is a folder; give the name of a file in it"),
        ("", "is a folder"),
        ("file/x", "'file' is no folder, so that 'x' cannot be written there"),
        ("file/y/x", "'file' is no folder"),
        ("x\0y", "nothing can be written to 'x.x00y'"),
        ("n" * 300, "nothing can be written to 'nnn.*name too long"),
        (None, "nothing can be written to 'None'"),
        (7, "nothing can be written to '7'"),
    ],
)
def test_what_is_no_place_for_a_file_is_refused_in_a_sentence(tmp_path, monkeypatch, path, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    for function in (check_output, lambda given: write_file(given, "")):
        with pytest.raises(InputError, match=words):
            function(path)


def test_no_two_results_go_to_one_file_however_it_is_called(tmp_path):
    (tmp_path / "link").symlink_to("a")
    with pytest.raises(InputError, match="--json and --html cannot both be written to"):
        check_outputs({"--json": tmp_path / "a", "--html": tmp_path / "link"})
    assert len(check_outputs({"--json": "/dev/null", "--html": "/dev/null", "--plot": None})) == 2


def test_half_a_file_is_never_left_and_the_old_one_stays(tmp_path, monkeypatch):
    path = tmp_path / "x"
    path.write_text("old")
    for stopped in (OSError(28, "No space left on device"), KeyboardInterrupt(), SystemExit(143)):

        def fail(*_, stopped=stopped):
            raise stopped

        monkeypatch.setattr("robust_ik.runtime.output_files._keep_rights", fail)
        with pytest.raises((InputError, KeyboardInterrupt, SystemExit)):
            write_file(path, "new")
        assert path.read_text() == "old"
        assert not litter(tmp_path)


def test_a_file_that_cannot_be_replaced_is_written_to(tmp_path, monkeypatch):
    path = tmp_path / "mounted"
    path.write_text("a long old text")

    def busy(*_):
        raise OSError(16, "Device or resource busy")

    monkeypatch.setattr("pathlib.Path.replace", busy)
    write_file(path, "new")
    assert path.read_text() == "new"
    assert not litter(tmp_path)


def test_half_letters_are_written_as_escapes(tmp_path):
    write_file(tmp_path / "x", "a \ud800 b")
    assert (tmp_path / "x").read_text() == "a \\ud800 b"


def test_figures_are_written_as_files_are(tmp_path):
    from matplotlib.figure import Figure

    path, read = tmp_path / "pipe.png", io.BytesIO()
    os.mkfifo(path)
    reader = threading.Thread(target=lambda: read.write(path.read_bytes()))
    reader.start()
    save_figure(Figure(figsize=(1, 1)), path, 50)
    reader.join(10)
    assert read.getvalue().startswith(b"\x89PNG")
    assert stat.S_ISFIFO(path.stat().st_mode)
