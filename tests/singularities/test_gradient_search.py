"""The paper's search, formula by formula: what each of its equations must give, at configurations of real arms."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.singularities import gradient_descent, gradient_search
from robust_ik.singularities.find.gradient_clusters import rotated_block, rotated_gradients, shortest_mean
from robust_ik.singularities.find.gradient_search import GAMMAS, Reading, Slope, directions
from robust_ik.singularities.find.line_search import SEARCHES, least_along
from robust_ik.singularities.geometry.screw_chain import ScrewChain

ARMS = [("pa10", 2), ("pa10", 3), ("ur5", 2), ("kinova", 3)]
READINGS = [
    {}, {"rotated": False}, {"cluster": 0.3}, {"line_search": "exact"}, {"line_search": "nearest"},
    {"combination": "shortest", "cluster": 0.3},
]  # fmt: skip


@cache
def chain(name):
    return ScrewChain.of(rik.load(name))


def sigma(name, values, corank):
    """σ_{m−k+1} by NumPy from Pinocchio's Jacobian."""
    robot = rik.load(name)
    s = np.linalg.svd(robot.jacobian(robot.configuration(values)), compute_uv=False)
    return s[..., s.shape[-1] - corank]


def clustered(name, corank, size, count=40):
    """Configurations at which the last `size` of the k weakest values count as a cluster of 60 %, and slopes there."""
    values = chain(name).random(np.random.default_rng(3), 3000)
    slope = Slope.at(chain(name), values, corank)
    which = np.flatnonzero(slope.clusters(0.6) == size)[:count]
    assert len(which) > 10
    return values[which], Slope(slope.weakest[which], slope.block[which])


# ------------------------------------------------------------------------------------------ the slope, (7) and (10)
@pytest.mark.parametrize("name, corank", ARMS)
def test_the_diagonal_of_a_slope_is_the_gradient_of_each_singular_value(name, corank, rng):
    values, h = chain(name).random(rng, 20), 1e-6
    slope = Slope.at(chain(name), values, corank)
    for i in range(corank):
        ahead, behind = (sigma(name, values[:, None] + each * np.eye(chain(name).n), corank - i) for each in (h, -h))
        difference = (ahead - behind) / (2 * h)
        simple = np.abs(np.diff(slope.weakest, axis=1)).min(axis=1) > 1e-2
        assert_allclose(slope.block[simple, i, i], difference[simple], atol=1e-6)


@pytest.mark.parametrize("name, corank", ARMS)
def test_beside_the_diagonal_a_slope_has_the_derivative_between_two_pairs(name, corank, rng):
    values, h = chain(name).random(rng, 5), 1e-6
    found = rik.svd(chain(name).jacobian(values))
    U, V = found.U[..., -corank:], np.swapaxes(found.Vt, 1, 2)[..., -corank:]
    block = Slope.at(chain(name), values, corank).block
    for k, unit in enumerate(np.eye(chain(name).n)):
        change = (chain(name).jacobian(values + h * unit) - chain(name).jacobian(values - h * unit)) / (2 * h)
        assert_allclose(block[..., k], np.swapaxes(U, 1, 2) @ change @ V, atol=1e-7)


def test_a_cluster_holds_the_target_and_all_that_are_near_it():
    weakest = np.array([[1.0, 0.99, 0.5], [1.0, 0.97, 0.96], [1.0, 0.985, 0.981], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    slope = Slope(weakest, np.zeros((5, 3, 3, 6)))
    assert_array_equal(slope.clusters(0.02), [2, 1, 3, 1, 3])
    assert_array_equal(slope.clusters(0.04), [2, 3, 3, 1, 3])


# ------------------------------------------------------------------------------------------ a step, (11)
@pytest.mark.parametrize("corank", [1, 2, 3])
def test_each_step_of_fixed_length_goes_against_the_gradient_alone_by_alpha(corank):
    start = clustered("pa10", 3, 3)[0][0]
    run = gradient_descent(chain("pa10"), corank, start, step=0.01, cluster=0.6, max_iterations=10)
    assert_allclose(np.diff(run.values, axis=0), -0.01 * run.gradients, atol=1e-14)
    for q, gradient in zip(run.values, run.gradients):
        expected = rik.load("pa10").singular_value_gradients(q)[-corank]
        assert_allclose(gradient, expected, atol=1e-9)
    assert (np.diff(run.s[:, -corank]) < 0).all()


def test_a_descent_tells_the_angles_between_its_gradients():
    gradients = np.array([[1.0, 0.0], [0.0, 2.0], [0.0, -3.0], [1.0, -1.0]])
    run = rik.Descent(1, np.zeros((5, 2)), np.array([[1.0, 0.5 * 0.1**i] for i in range(5)]), gradients)
    assert_allclose(run.turns, np.radians([90, 180, 45]))
    assert_allclose(run.weakest, run.s[:, 1:])
    assert len(run) == 4
    assert not run.converged
    assert rik.Descent(1, np.zeros((1, 2)), np.array([[1.0, 1e-6]]), np.zeros((0, 2))).converged


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("name, corank", ARMS)
def test_a_line_search_goes_downhill_along_the_line_and_tells_sigma_there(name, corank, search, rng):
    values = chain(name).random(rng, 30)
    slope = Slope.at(chain(name), values, corank)
    downhill = slope.block[:, 0, 0]
    there, least = least_along(chain(name), values, corank, slope.weakest[:, 0], downhill, search)
    assert_allclose(least, sigma(name, there, corank), atol=1e-9)
    assert (least < slope.weakest[:, 0]).all()
    moved = values - there
    assert_allclose(
        np.sum(moved * downhill, axis=1), np.linalg.norm(moved, axis=1) * np.linalg.norm(downhill, axis=1), rtol=1e-6
    )
    assert np.abs(moved).max() <= 2 * 0.5 + 1e-9
    first = slope.weakest[:, 0]
    for other in (-downhill, 0 * downhill):
        there, least = least_along(chain(name), values, corank, first, other, search)
        stays = (there == values).all(axis=1)
        assert stays.sum() > 3
        assert_array_equal(least[stays], first[stays])
        assert (least[~stays] < first[~stays]).all()


@pytest.mark.parametrize("search", ["exact", "nearest"])
@pytest.mark.parametrize("name, corank", ARMS)
def test_an_exact_line_search_ends_where_neither_a_longer_nor_a_shorter_step_is_better(name, corank, search, rng):
    values = chain(name).random(rng, 60)
    slope = Slope.at(chain(name), values, corank)
    there, least = least_along(chain(name), values, corank, slope.weakest[:, 0], slope.block[:, 0, 0], search)
    beside = [sigma(name, values + length * (there - values), corank) for length in (0.999, 1.001)]
    downhill, first = slope.block[:, 0, 0], slope.weakest[:, 0]
    longest = 4 * first * np.abs(downhill).max(axis=1) / np.sum(downhill**2, axis=1)
    inside = np.abs(there - values).max(axis=1) < 0.99 * np.minimum(longest, 0.5)  # others end at the longest step
    assert inside.sum() >= 10
    assert (np.array(beside)[:, inside] >= least[inside] - 1e-9).all()
    if search == "nearest":
        on_the_way = [sigma(name, values + part * (there - values), corank) for part in np.linspace(0, 1, 6)]
        assert np.mean((np.diff(on_the_way, axis=0) < 1e-9).all(axis=0)) > 0.95  # dips between treads may be missed


# ------------------------------------------------------------------------------------------ rotating a cluster
def turned(block, R):
    """The block of pairs that are rotated by R, in plain sums."""
    return np.einsum("ac,cdk,bd->abk", R, block, R)


def total_angle(gradients):
    unit = gradients / np.linalg.norm(gradients, axis=-1, keepdims=True)
    pairs = [(i, j) for i in range(len(unit)) for j in range(i + 1, len(unit))]
    return sum(np.arccos(np.clip(unit[i] @ unit[j], -1, 1)) for i, j in pairs)


def test_two_gradients_are_those_of_pairs_rotated_by_one_angle_and_no_angle_brings_them_nearer(rng):
    for block in rng.normal(size=(20, 2, 2, 6)):
        found = rotated_gradients(block[None])[0]
        every = []
        for phi in np.linspace(0, np.pi / 2, 721):
            c, s = np.cos(phi), np.sin(phi)
            B = turned(block, np.array([[c, s], [-s, c]]))
            every.append((total_angle([B[0, 0], B[1, 1]]), np.abs(found - [B[0, 0], B[1, 1]]).max()))
        angles, off = np.array(every).T
        assert off.min() < 1e-9
        assert total_angle(found) <= angles.min() + 0.15  # the grid is one of 3.75°, and turns by twice that


def test_gradients_of_an_exact_cluster_do_not_hang_on_the_pairs_that_the_svd_happens_to_give(rng):
    for block in rng.normal(size=(20, 2, 2, 6)):
        block = (block + block.swapaxes(0, 1)) / 2
        least = total_angle(rotated_gradients(block[None])[0])
        for phi in rng.uniform(0, np.pi, 5):
            c, s = np.cos(phi), np.sin(phi)
            again = rotated_gradients(turned(block, np.array([[c, s], [-s, c]]))[None])[0]
            assert abs(total_angle(again) - least) < 0.2


def test_of_three_gradients_the_sum_of_all_angles_is_nearly_the_least(rng):
    behind = []
    for block in rng.normal(size=(12, 3, 3, 6)):
        found = total_angle(rotated_gradients(block[None])[0])
        turns = np.linalg.qr(rng.normal(size=(400, 3, 3)))[0]
        every = [total_angle(np.einsum("aak->ak", turned(block, R))) for R in turns]
        behind.append(np.mean(np.array(every) < found))
    assert np.mean(behind) < 0.04


def test_of_three_rotated_pairs_no_turn_in_any_plane_brings_the_gradients_much_nearer(rng):
    blocks = rotated_block(rng.normal(size=(20, 3, 3, 6)))
    for a, b in ((0, 1), (0, 2), (1, 2)):
        gains = []
        for block in blocks:
            angles = []
            for phi in np.linspace(0, np.pi / 2, 24, endpoint=False):
                R = np.eye(3)
                R[a, a] = R[b, b] = np.cos(phi)
                R[a, b], R[b, a] = np.sin(phi), -np.sin(phi)
                angles.append(total_angle(np.einsum("aak->ak", turned(block, R))))
            gains.append(angles[0] - min(angles))
        assert np.mean(gains) < 0.04


# ------------------------------------------------------------------------------------------ combining its gradients
@pytest.mark.parametrize("name, corank, size", [("pa10", 2, 2), ("pa10", 3, 2), ("pa10", 3, 3), ("ur5", 2, 2)])
def test_the_combined_gradient_is_a_mean_of_the_clusters_with_the_best_gamma(name, corank, size):
    """Weights γ and 1 − γ, none negative, their sum 1; of the grid's γ the one that leads to the least σ."""
    values, slope = clustered(name, corank, size)
    found = directions(chain(name), values, slope, Reading(cluster=0.6))
    inner = 0
    for q, first, gradients, direction in zip(
        values, slope.weakest[:, 0], rotated_gradients(slope.block[:, :size, :size]), found
    ):
        weights, *_ = np.linalg.lstsq(gradients.T, direction, rcond=None)
        assert_allclose(weights @ gradients, direction, atol=1e-9)
        assert_allclose(weights.sum(), 1, atol=1e-6)
        assert weights.min() > -1e-6
        inner += np.sort(weights)[-2] > 0.1

        def reached(along, q=q, first=first):
            return least_along(chain(name), q[None], corank, np.array([first]), along[None], None)[1][0]

        best = gradients[0]
        for other in gradients[1:]:
            best = min((gamma * best + (1 - gamma) * other for gamma in GAMMAS), key=reached)
        assert_allclose(reached(direction), reached(best), atol=1e-9)
        assert reached(direction) <= min(reached(gradients[0]), reached(gradients[-1])) + 1e-9
    assert inner > 3


def test_gamma_goes_from_one_gradient_alone_to_the_other_alone():
    assert GAMMAS[0] == 0
    assert GAMMAS[-1] == 1
    assert (np.diff(GAMMAS) > 0).all()
    assert len(GAMMAS) > 3


def test_only_values_of_a_cluster_are_combined_and_only_where_rotation_is_asked_for():
    values, slope = clustered("pa10", 3, 2)
    alone = slope.block[:, 0, 0]
    assert_array_equal(directions(chain("pa10"), values, slope, Reading(rotated=False, cluster=0.6)), alone)
    narrow = slope.clusters(0.02) == 1
    assert narrow.sum() > 5
    assert_array_equal(directions(chain("pa10"), values, slope, Reading())[narrow], alone[narrow])
    assert np.abs(directions(chain("pa10"), values, slope, Reading(cluster=0.6)) - alone).max() > 0.1


# ------------------------------------------------------------------------------------------ the shortest mean
@pytest.mark.parametrize("size", [2, 3])
def test_no_mean_of_a_cluster_is_shorter_than_the_shortest(size, rng):
    block = rng.normal(size=(30, size, size, 4)) + 0.3
    found = shortest_mean(block)
    length = np.linalg.norm(found, axis=1)
    pairs = rng.normal(size=(4000, size))
    pairs /= np.linalg.norm(pairs, axis=1, keepdims=True)
    every = np.einsum("pa,pb,nabk->npk", pairs, pairs, block)
    # It leans towards each gradient at least by its own length squared: a hyperplane has all of them on one side.
    leaning = np.einsum("npk,nk->np", every, found)
    assert (leaning.min(axis=1) >= length**2 - 2e-3).all()
    for weights in rng.dirichlet(np.full(10, 0.3), 50):
        means = np.einsum("p,npk->nk", weights, every[:, rng.choice(4000, 10)])
        assert (np.linalg.norm(means, axis=1) >= length - 1e-3).all()


def test_against_the_shortest_mean_all_of_an_exact_cluster_fall():
    _, slope = clustered("pa10", 2, 2)
    found = shortest_mean(slope.block)
    for block, direction in zip(slope.block, found):
        even = (block + block.swapaxes(0, 1)) / 2
        rates = np.linalg.eigvalsh(even @ direction)
        assert rates.min() >= direction @ direction - 2e-3


# ------------------------------------------------------------------------------------------ the search
@pytest.mark.parametrize("options", READINGS, ids=str)
def test_whatever_is_read_into_the_paper_no_search_climbs_and_what_converges_is_singular(options):
    starts = chain("pa10").random(np.random.default_rng(6), 25)
    before = starts.copy()
    found = gradient_search(chain("pa10"), 2, starts, **options)
    assert_array_equal(starts, before)
    assert (sigma("pa10", found.values, 2) <= sigma("pa10", starts, 2) + 1e-12).all()
    assert sigma("pa10", found.values[found.converged], 2).max() < 1e-10
    assert found.converged.sum() >= 4
    assert found.tries.max() <= 200


@pytest.mark.parametrize("options", READINGS, ids=str)
def test_one_descent_makes_the_steps_of_the_search(options):
    starts = chain("pa10").random(np.random.default_rng(8), 6)
    found = gradient_search(chain("pa10"), 3, starts, max_iterations=3, **options)
    for start, end in zip(starts, found.values):
        run = gradient_descent(chain("pa10"), 3, start, max_iterations=3, **options)
        assert_allclose(run.values[-1], end, atol=1e-6)
        assert len(run) <= 3


def test_an_exact_line_search_reaches_more_than_a_grid():
    starts = chain("pa10").random(np.random.default_rng(1), 60)
    grid, exact = (gradient_search(chain("pa10"), 2, starts, line_search=each) for each in ("grid", "exact"))
    assert exact.converged.mean() > grid.converged.mean() + 0.1


def test_to_corank_3_most_searches_end_where_the_target_is_in_no_cluster():
    """So that no reading of (12) to (14) can help there: σ4 has a narrow valley, and its gradient leads across it."""
    starts = chain("pa10").random(np.random.default_rng(1), 60)
    found = gradient_search(chain("pa10"), 3, starts, line_search="exact")
    weakest = found.residual.weakest[~found.converged]
    assert np.mean(weakest[:, 1] < 0.98 * weakest[:, 0]) > 0.5
    assert 0.01 < np.median(weakest[:, 0]) < 0.1


def test_more_patience_and_more_steps_are_more_steps():
    starts = chain("pa10").random(np.random.default_rng(1), 20)
    for options in ({"max_iterations": 5}, {"patience": 1}):
        few, many = (gradient_search(chain("pa10"), 3, starts, **each) for each in (options, {}))
        assert few.tries.sum() < many.tries.sum()
        assert few.tries.max() <= options.get("max_iterations", 200)


# ------------------------------------------------------------------------------------------ as public names
def test_a_robot_stands_for_its_chain():
    robot, starts = rik.load("planar_2r"), np.array([[0.3, 1.0], [1.0, -2.0]])
    found = rik.gradient_search(robot, 1, starts)
    assert found.converged.all()
    assert_allclose(np.sin(found.values[:, 1]), 0, atol=1e-9)
    assert_array_equal(found.values, gradient_search(ScrewChain.of(robot), 1, starts).values)
    assert rik.gradient_descent(robot, 1, starts[0]).converged
    assert len(rik.gradient_search(robot, 1, np.zeros((0, 2))).values) == 0


@pytest.mark.parametrize(
    "options, message",
    [
        ({"robot": "panda"}, "robot must be a Robot, got 'panda'"),
        ({"corank": 3}, "corank must be 1 to 2"),
        ({"cluster": 1.0}, "cluster must be ≥ 0 and < 1, got 1"),
        ({"cluster": -0.1}, "cluster must be ≥ 0 and < 1"),
        ({"combination": "best"}, "combination must be one of 'searched', 'shortest', got 'best'"),
        ({"line_search": "none"}, "line_search must be one of 'grid', 'exact', 'nearest', got 'none'"),
        ({"rotated": "yes"}, "rotated must be True or False"),
        ({"max_iterations": 0}, "max_iterations must be at least 1, got 0"),
    ],
)
def test_what_cannot_be_meant_is_refused(options, message):
    with pytest.raises(rik.InputError, match=message):
        rik.gradient_search(**{"robot": rik.load("planar_2r"), "corank": 1, "starts": np.zeros((1, 2))} | options)
    with pytest.raises(rik.InputError, match=message):
        rik.gradient_descent(**{"robot": rik.load("planar_2r"), "corank": 1, "start": np.zeros(2)} | options)


def test_starts_and_numbers_of_a_search_are_checked():
    robot = rik.load("planar_2r")
    with pytest.raises(rik.InputError, match=r"starts must have shape .*, got \(2,\)"):
        rik.gradient_search(robot, 1, np.zeros(2))
    with pytest.raises(rik.InputError, match=r"starts must have shape \(N, 2\), got \(3, 1, 2\)"):
        rik.gradient_search(robot, 1, np.zeros((3, 1, 2)))
    with pytest.raises(rik.InputError, match="starts must have shape"):
        rik.gradient_search(robot, 1, np.zeros((4, 3)))
    with pytest.raises(rik.InputError, match="patience must be at least 1, got 0"):
        rik.gradient_search(robot, 1, np.zeros((1, 2)), patience=0)
    with pytest.raises(rik.InputError, match="tolerance must be > 0"):
        rik.gradient_search(robot, 1, np.zeros((1, 2)), 0.0)
    with pytest.raises(rik.TipError, match="without a tip"):
        rik.gradient_search(rik.load("tiago", whole_tree=True), 1, np.zeros((1, 2)))
