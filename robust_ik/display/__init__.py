"""Displays robots, runs and singularities as MeshCat scenes, live or in files. It never changes what it is given."""

from robust_ik.display.drawings.configuration import DrawnConfiguration, draw_configuration
from robust_ik.display.drawings.drawn_robot import DrawnRobot, MissingMesh, draw_robot
from robust_ik.display.drawings.drawn_runs import draw_run
from robust_ik.display.figures.curves import curves_figure, plot_curves
from robust_ik.display.figures.descents import descents_figure
from robust_ik.display.figures.gains import plot_gains
from robust_ik.display.figures.run_figures import plot_runs, runs_figure
from robust_ik.display.figures.stills import stills_figure
from robust_ik.display.figures.tradeoff import plot_tradeoff
from robust_ik.display.figures.workspaces import plot_workspace, workspace_figure
from robust_ik.display.live.live_view import LiveView, view
from robust_ik.display.pages.atlas_page import write_atlas_html
from robust_ik.display.pages.comparison_page import write_html
from robust_ik.display.pages.robustness_pages import write_robustness_html
from robust_ik.display.scene.scene import Scene, serve

__all__ = [
    "DrawnConfiguration",
    "DrawnRobot",
    "LiveView",
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
    "plot_tradeoff",
    "plot_workspace",
    "runs_figure",
    "serve",
    "stills_figure",
    "view",
    "workspace_figure",
    "write_atlas_html",
    "write_html",
    "write_robustness_html",
]
