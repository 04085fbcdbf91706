"""How far limits turn a tool's motion from what it was asked for: this package's resolvers beside Pink.

`python -m benchmarks.direction_beside_pink` drives a UR5's tool along straight lines through its elbow and its wrist
singularity, within its speed limits, and prints a table. At every configuration of the first resolver's run Pink is
asked for the same twist. Directions that are being lost (σ ≤ γσ₁) do not count: nobody can give those.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pink
import pinocchio as pin

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish
from robust_ik.simulation.scenarios import StraightLine, ur5_elbow, ur5_wrist
from robust_ik.simulation.scenarios.straight_line import DT, Asked, turned

LIMITERS = {
    "robust_ik, `Sliding`": rik.Sliding(),
    "robust_ik, `Scaling`": rik.Scaling(),
    "robust_ik, `Saturation`": rik.Saturation(),
    "robust_ik, `QuadraticProgram(keep_direction=True)`": rik.QuadraticProgram(keep_direction=True),
    "robust_ik, `QuadraticProgram()`": rik.QuadraticProgram(),
}


def runs(line: StraightLine) -> dict[str, list[Asked]]:
    """The steps of every limiter along the line."""
    inverse = rik.JParse(line.gamma)
    return {name: list(line.steps(rik.TaskPriority(inverse, limiter))) for name, limiter in LIMITERS.items()}


def pink_velocities(line: StraightLine, steps: Iterable[Asked], lm_damping: float = 0.0) -> list[np.ndarray]:
    """What Pink gives for the same twists at the same configurations, with its default limits.

    Args:
        line: The motion.
        steps: What was asked, where.
        lm_damping: Of Pink's frame task; 0 is its default, its UR5 example has 1.
    """
    model, found = line.robot.model, []
    configuration = pink.Configuration(model, model.createData(), line.q0)
    task = pink.tasks.FrameTask(line.robot.tip, position_cost=1.0, orientation_cost=1.0, lm_damping=lm_damping)
    for step in steps:
        configuration.update(step.q)
        pose = configuration.get_transform_frame_to_world(line.robot.tip)
        turn = pin.exp3(DT * step.twist[3:]) @ pose.rotation
        task.set_target(pin.SE3(turn, pose.translation + DT * step.twist[:3]))
        found.append(pink.solve_ik(configuration, [task], DT, solver="daqp"))
    return found


def largest_turn(line: StraightLine, steps: Iterable[Asked], velocities: Iterable[np.ndarray]) -> float:
    """The largest angle between asked and given, degrees."""
    angles = [turned(step.J, step.twist, qdot, line.gamma) for step, qdot in zip(steps, velocities)]
    return float(np.degrees(max(angles)))


def main() -> None:
    arguments = parser(__doc__, "task_stacks.md").parse_args()
    columns = ("resolver", "elbow: turned by [°]", "least scale", "wrist: turned by [°]", "least scale")
    rows: dict[str, list[str]] = {}
    for line in (ur5_elbow(), ur5_wrist()):
        made = runs(line)
        for name, steps in made.items():
            turn = largest_turn(line, steps, [step.resolution.qdot for step in steps])
            least = min(step.resolution.scale[0] for step in steps)
            rows.setdefault(name, []).extend([f"{turn:.1e}" if turn < 0.01 else f"{turn:.1f}", f"{least:.2f}"])
        first = next(iter(made.values()))
        for name, lm_damping in (("Pink", 0.0), ("Pink, `lm_damping=1`", 1.0)):
            turn = largest_turn(line, first, pink_velocities(line, first, lm_damping))
            rows.setdefault(name, []).extend([f"{turn:.1f}", "–"])
    table = markdown(columns, [(name, *cells) for name, cells in rows.items()])
    publish(table, "task_stacks.md", "direction", write=arguments.write)


if __name__ == "__main__":
    main()
