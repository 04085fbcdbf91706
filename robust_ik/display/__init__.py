"""Robots, runs and singularities to look at: MeshCat scenes, live or as files. It only ever reads what it is given."""

from robust_ik.display.atlas_page import write_atlas_html
from robust_ik.display.configuration import draw_configuration
from robust_ik.display.curves import curves_figure, plot_curves
from robust_ik.display.descents import descents_figure
from robust_ik.display.drawn_robot import DrawnRobot, MissingMesh, draw_robot
from robust_ik.display.gains import plot_gains
from robust_ik.display.report import write_html
from robust_ik.display.run_figures import plot_runs, runs_figure
from robust_ik.display.runs import draw_run
from robust_ik.display.scene import Scene, serve
from robust_ik.display.stills import stills_figure
from robust_ik.display.workspaces import plot_workspace, workspace_figure

__all__ = [
    "DrawnRobot",
    "MissingMesh",
    "Scene",
    "curves_figure",
    "descents_figure",
    "draw_configuration",
    "draw_robot",
    "draw_run",
    "plot_curves",
    "plot_gains",
    "plot_runs",
    "plot_workspace",
    "runs_figure",
    "serve",
    "stills_figure",
    "workspace_figure",
    "write_atlas_html",
    "write_html",
]
