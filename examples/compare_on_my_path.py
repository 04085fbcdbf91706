"""Runs several inverses along a path from a CSV file (time, x, y, z) and writes a page that shows them side by side."""

import csv
from pathlib import Path

import numpy as np

import robust_ik as rik
from robust_ik.display import write_html

robot = rik.load("xarm7")
q = robot.configuration([0.0, 0.3, 0.0, 0.9, 0.0, 0.6, 0.0])
start = robot.pose(q)

file = Path("path.csv")
if not file.exists():  # one to play with: out beyond the arm's reach, and back
    rows = [(t, *(start[:3, 3] + (0.35 * np.sin(np.pi * t / 8), 0, 0))) for t in np.linspace(0, 8, 81)]
    with file.open("w", newline="") as out:
        csv.writer(out).writerows([("time", "x", "y", "z"), *rows])

table = np.array([[float(value) for value in row] for row in list(csv.reader(file.open()))[1:]])
times, places = table[:, 0], table[:, 1:]


def path(time):
    """The tool's pose at a time, its orientation kept."""
    pose = start.copy()
    pose[:3, 3] = [np.interp(time, times, column) for column in places.T]
    return pose


methods = (rik.JParse(), rik.DampedLeastSquares(), rik.Chiaverini(), rik.MoorePenrose())
follow = rik.Follow(path, gain=5.0)
runs = [rik.simulate(robot, each, follow, q, duration=times[-1], calm=False) for each in methods]  # as they are
for each, run in zip(methods, runs):
    print(f"{type(each).__name__:<20} peak {run.largest_speed:6.2f} rad/s, least σ {run.smallest_sigma:.1e}")
print(write_html("compared.html", runs, title="My path"))
