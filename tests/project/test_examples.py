"""The scripts in examples/ run as they are, and are listed."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
SCRIPTS = sorted(path.name for path in EXAMPLES.glob("*.py"))


def test_all_are_listed_and_each_says_in_one_line_what_it_does():
    listed = re.findall(r"^\| `(\w+\.py)` \|", (EXAMPLES / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == SCRIPTS
    assert len(SCRIPTS) == 10
    for name in SCRIPTS:
        assert re.match(r'"""[A-Z][^"\n]+\."""\n', (EXAMPLES / name).read_text(encoding="utf-8")), name


SAYS = {
    "servo_within_limits.py": r"tracking after \d\.\d\d s, error \d\.\de-05",
    "why_does_it_stop.py": r"The target can be reached(.|\n)*with Reach: 0\.0000 mm away",
    "thousand_poses.py": r"1000 of 1000 solved",
    "two_arms.py": r"never more than 0\.\d\d mm off each other",
    "keep_clear.py": r"table are 20\.\d mm apart",
    "show_what_is_lost.py": r"corank 1",
    "elbow_posture.py": r"joint ranges below +tool error \de-\d\d",
}
"""What holds of those that say how they went."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SCRIPTS)
def test_it_runs(name, tmp_path):
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name)], cwd=tmp_path, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    assert re.search(SAYS.get(name, r"\S"), done.stdout), done.stdout
