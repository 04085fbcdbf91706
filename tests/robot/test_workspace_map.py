"""Maps of what an arm can do where."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.display import plot_workspace, workspace_figure
from robust_ik.runtime.parallel import process_pool


def mapped(name="puma560", count=300, **options):
    return rik.map_workspace(rik.load(name), count, **options)


# ------------------------------------------------------------------------------------------------ the map
def test_a_map_holds_configurations_within_the_limits_and_what_pinocchio_says_of_them():
    robot, found = rik.load("puma560"), mapped()
    assert len(found) == 300
    assert ((robot.lower <= found.q) & (found.q <= robot.upper)).all()
    assert_array_equal(found.positions, robot.pose(found.q)[:, :3, 3])
    s = rik.svd(robot.jacobian(found.q)).s
    assert_allclose(found.sigma, s, atol=1e-13)
    assert_allclose(found.smallest_sigma, s[:, -1], atol=1e-13)
    assert_allclose(found.manipulability, rik.manipulability(robot.jacobian(found.q)), atol=1e-13)
    assert_allclose(1 / found.inverse_condition, rik.condition_number(robot.jacobian(found.q)), rtol=1e-9)


def test_rows_and_the_length_scale_are_those_that_were_asked_for():
    robot, rows = rik.load("puma560"), ("x", "y", "z", "wx")
    found = mapped(rows=rows, length_scale=0.5)
    J = robot.jacobian(found.q, rows=rows) / np.array([0.5, 0.5, 0.5, 1.0])[:, None]
    assert_allclose(found.sigma, rik.svd(J).s, atol=1e-13)
    assert found.rows == rows
    assert robot.rows != rows


def test_the_elbow_of_a_planar_arm_decides_its_manipulability():
    robot = rik.load("planar_2r")
    found = rik.map_workspace(robot, 500)
    assert_allclose(found.manipulability, np.abs(np.linalg.det(robot.jacobian(found.q))), atol=1e-12)


def test_a_jacobian_of_zeros_is_as_singular_as_can_be():
    found = mapped(count=2)
    still = rik.WorkspaceMap(found.robot, found.rows, 1.0, 0, found.q, found.positions, np.zeros((2, 6)))
    assert_array_equal(still.inverse_condition, [0.0, 0.0])


@pytest.mark.slow
def test_the_same_seed_gives_the_same_map_whoever_makes_it_and_more_of_it_begins_with_it():
    robot = rik.load("kinova")  # continuous joints: nq is more than n
    alone = rik.map_workspace(robot, 10_500, rng=3)
    told = []
    with process_pool(2) as pool:
        shared = rik.map_workspace(robot, 10_500, rng=3, executor=pool, progress=lambda *counts: told.append(counts))
    for name in ("q", "positions", "sigma"):
        assert getattr(alone, name).tobytes() == getattr(shared, name).tobytes()
        assert not getattr(shared, name).flags.writeable
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert_array_equal(rik.map_workspace(robot, 5_000, rng=3).q, alone.q[:5_000])
    assert not np.array_equal(rik.map_workspace(robot, 10, rng=4).q, alone.q[:10])


@pytest.mark.parametrize("count", [0, -1, 1.5, True, "many"])
def test_counts_that_cannot_be_meant_are_refused(count):
    with pytest.raises(rik.InputError, match="count must be a whole number"):
        mapped(count=count)


def test_a_robot_without_a_tip_is_refused():
    with pytest.raises(rik.TipError, match="without a tip"):
        rik.map_workspace(rik.load("anymal_b", whole_tree=True), 10)


# ------------------------------------------------------------------------------------------------ cells
@pytest.mark.parametrize("axes", [("x", "y", "z"), ("z", "x"), ("y",)])
def test_cells_hold_every_configuration_once_with_the_best_and_the_mean(axes):
    found = mapped()
    cells = found.cells("manipulability", size=0.2, axes=axes)
    assert cells.count.sum() == len(found)
    assert cells.count.shape == tuple(len(edges) - 1 for edges in cells.edges)
    filled = cells.count > 0
    assert np.isnan(cells.best[~filled]).all()
    assert np.isnan(cells.mean[~filled]).all()
    assert_allclose(np.sum(cells.mean[filled] * cells.count[filled]), found.manipulability.sum())
    place = np.unravel_index(np.argmax(cells.count), cells.count.shape)
    inside = np.ones(len(found), dtype=bool)
    for axis, edges, index in zip(axes, cells.edges, place):
        along = found.positions[:, "xyz".index(axis)]
        inside &= (edges[index] <= along) & (along < edges[index + 1])
    assert inside.sum() == cells.count[place]
    assert cells.best[place] == found.manipulability[inside].max()
    assert_allclose(cells.mean[place], found.manipulability[inside].mean())


def test_an_arm_that_stays_in_its_plane_has_one_layer_of_cells():
    assert mapped("planar_2r").cells(size=0.1).count.shape[2] == 1


@pytest.mark.parametrize(
    "options, message",
    [
        ({"quantity": "smallest"}, "no quantity 'smallest'; did you mean 'smallest sigma'"),
        ({"size": 0}, "size"),
        ({"size": 1e-4}, "more than 10000000: take larger ones"),
        ({"axes": ("x", "x")}, "axes must be some of x y z, each once"),
        ({"axes": ()}, "axes must be"),
        ({"axes": ("wx",)}, "axes must be"),
    ],
)
def test_cells_that_cannot_be_meant_are_refused(options, message):
    with pytest.raises(rik.InputError, match=message):
        mapped().cells(**options)


# ------------------------------------------------------------------------------------------------ figures
@pytest.mark.parametrize("name, quantity", [("panda", "smallest sigma"), ("planar_2r", "inverse condition")])
def test_the_figure_shows_the_best_and_the_mean_from_three_sides(tmp_path, name, quantity):
    figure = workspace_figure(mapped(name), quantity)
    assert [ax.get_title() for ax in figure.axes[:6]] == ["best"] * 3 + ["mean"] * 3
    assert {ax.get_xlabel() for ax in figure.axes[:6]} == {"x [m]", "y [m]"}
    assert quantity in figure.axes[6].get_ylabel()
    path = plot_workspace(mapped(name), tmp_path / "new" / "map.png", quantity, size=0.1)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_figures_that_cannot_be_meant_are_refused(tmp_path):
    with pytest.raises(rik.InputError, match="no quantity"):
        workspace_figure(mapped(), "beauty")
    with pytest.raises(rik.InputError, match="one of"):
        plot_workspace(mapped(), tmp_path / "map.txt")
