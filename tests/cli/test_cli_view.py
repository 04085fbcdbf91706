"""`robust-ik view`: it says where the page is, serves it until it is told to end, and leaves nothing behind."""

import re
import signal
import subprocess
import sys
import urllib.request

import pytest

import robust_ik as rik

SECONDS = 120
ROBUST_IK = [sys.executable, "-c", "from robust_ik.cli import main; main()"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_page_is_served_until_a_signal_ends_it(number, tmp_path):
    atlas = rik.find_singularities(rik.load("planar_3r"), starts=50, certify=False).save(tmp_path / "atlas.json")
    command = [*ROBUST_IK, "view", "planar_3r", "--no-browser", "--atlas", str(atlas)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        try:
            url = next(found[0] for line in program.stdout if (found := re.findall(r"http://\S+", line)))
            with urllib.request.urlopen(url, timeout=SECONDS) as answer:
                assert 'id="joints"' in answer.read().decode()
            program.send_signal(number)
            assert program.wait(SECONDS) == 128 + number
            assert "Traceback" not in program.stderr.read()
        finally:
            program.kill()


def test_a_wrong_robot_is_one_sentence():
    command = [*ROBUST_IK, "view", "no_such_robot", "--no-browser"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    assert ended.returncode == 1
    assert "no_such_robot" in ended.stderr
    assert "Traceback" not in ended.stderr
