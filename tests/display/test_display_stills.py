"""Figures of arms that stand still."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.display import stills_figure
from robust_ik.display.figures.stills import lost_basis

PI = np.pi


def test_each_configuration_has_a_panel_that_can_be_drawn():
    configurations = {"(a)": np.zeros(7), "(b)": [PI, 0, PI, PI, PI, PI, PI], "free": rik.load("pa10").rest}
    figure = stills_figure(rik.load("pa10"), configurations)
    assert [axes.get_title() for axes in figure.axes] == list(configurations)
    FigureCanvasAgg(figure).draw()
    # A line is a bone, an axis, the tip; lost rotations add a line and a ring. At rest none is added.
    counts = [len(axes.lines) for axes in figure.axes]
    assert counts[0] == counts[1] == counts[2] + 2


@pytest.mark.parametrize("name", ["tiago", "duleba_3r", "planar_2r"])
def test_any_arm_can_be_drawn_at_zero(name):
    robot = rik.load(name)
    FigureCanvasAgg(stills_figure(robot, {name: robot.neutral})).draw()


def test_the_lost_basis_is_sparse_and_has_six_rows():
    assert_allclose(lost_basis(rik.load("pa10"), np.zeros(7)), np.eye(6)[:, 1:4], atol=1e-12)
    lost = lost_basis(rik.load("almarkhi_4dof"), [-3.11, 3.02, -1.53, 0.15])
    assert lost.shape == (6, 1)
    assert_allclose(lost[3:], 0, atol=0)
    assert lost_basis(rik.load("pa10"), rik.load("pa10").rest).shape == (6, 0)


def test_what_cannot_be_drawn_is_refused():
    robot = rik.load("pa10")
    with pytest.raises(rik.InputError, match="nothing to draw"):
        stills_figure(robot, {})
    with pytest.raises(rik.InputError, match="configuration must have shape"):
        stills_figure(robot, {"short": np.zeros(6)})
    with pytest.raises(rik.InputError, match="tolerance must be"):
        stills_figure(robot, {"zero": np.zeros(7)}, tolerance=0)
    with pytest.raises(rik.TipError, match="without a tip"):
        stills_figure(rik.load("tiago", whole_tree=True), {"zero": rik.load("tiago", whole_tree=True).neutral})
