"""Finds every family of singular configurations of an arm and writes them as a LaTeX table."""

from pathlib import Path

import robust_ik as rik

robot = rik.load("puma560")
atlas = rik.find_singularities(robot, starts=300)
print(atlas.explanation)
Path("puma560.tex").write_text(atlas.latex(), encoding="utf-8")
for row in atlas:
    print(f"corank {row.corank}: {row.words}")
