"""The ladder of solutions finds the shortest motion: as trying all ways does."""

import itertools

import numpy as np
import pytest

from robust_ik.kernels.paths import ladder
from robust_ik.kernels.paths import ladder_layout as lay

FREE = np.array([[0.0, 1.0], [-np.inf, -np.inf], [np.inf, np.inf], [1.0, 2.0]])


def climbed(solutions, counts, starts, joints=FREE, banned=(), longest=1.5, most=64):
    p, _, n = solutions.shape
    states, numbers = np.full((p, most, lay.VALUES + n), np.nan), np.zeros((p, lay.NUMBERS))
    for i, (node, values) in enumerate(starts):
        states[0, i] = [node, 0.0, -1.0, -1.0, *values]
    numbers[0, lay.ALIVE] = len(starts)
    bans = np.array(banned, dtype=float).reshape(-1, 3)
    reached = ladder.compiled(
        solutions, np.array(counts, dtype=float), joints, bans, longest, states, numbers, np.empty(solutions.shape[1])
    )
    return reached, states, numbers


def by_trying(solutions, counts, start, longest):
    """The least motion to the last pose over all ways; infinite if there is none."""
    best = np.inf
    for way in itertools.product(*[range(c) for c in counts[1:]]):
        at, cost = start, 0.0
        for layer, node in enumerate(way, 1):
            d = solutions[layer, node] - at
            d[0] -= 2 * np.pi * np.round(d[0] / (2 * np.pi))
            if np.abs(d * [1, 2]).max() > longest:
                break
            cost += np.linalg.norm(d * [1, 2])
            at = at + d
        else:
            best = min(best, cost)
    return best


def test_the_least_motion_is_found(rng):
    ends = []
    for _ in range(60):
        counts = rng.integers(1, 4, 6)
        solutions = rng.uniform(-1, 1, (6, 3, 2)) + 2 * np.pi * rng.integers(-2, 3, (6, 3, 1)) * [1, 0]
        reached, states, numbers = climbed(solutions, counts, [(0, solutions[0, 0])])
        wanted = by_trying(solutions, counts, solutions[0, 0], 1.5)
        ends.append(reached == 5)
        assert (reached == 5) == np.isfinite(wanted)
        if reached == 5:
            assert states[5, : int(numbers[5, lay.ALIVE]), lay.COST].min() == pytest.approx(wanted)
    assert 0.2 < np.mean(ends) < 0.9


def test_a_step_that_is_banned_is_not_taken():
    solutions = np.array([[[0.0, 0], [0, 0]], [[0.1, 0], [0.5, 0]], [[0.2, 0], [0, 0]]])
    reached, states, _ = climbed(solutions, [1, 2, 1], [(0, [0.0, 0.0])])
    assert reached == 2
    assert states[2, 0, lay.COST] == pytest.approx(0.2)
    reached, states, numbers = climbed(solutions, [1, 2, 1], [(0, [0.0, 0.0])], banned=[(1, 0, 0)])
    assert states[2, 0, lay.COST] == pytest.approx(0.8)
    assert numbers[1, lay.ENDED] == 1
    reached, _, _ = climbed(solutions, [1, 2, 1], [(0, [0.0, 0.0])], banned=[(1, 0, 0), (0, 0, 1)])
    assert reached == 1


def test_a_limit_ends_a_motion_and_is_told():
    joints = np.array([[0.0], [-1.0], [0.15], [1.0]])
    solutions = np.array([[[0.0]], [[0.1]], [[0.2]]])
    reached, _, numbers = climbed(solutions, [1, 1, 1], [(0, [0.0])], joints)
    assert reached == 1
    assert numbers[1].tolist() == [1, 1, 1]
    turned = np.array([[[0.0]], [[0.1 + 2 * np.pi]], [[0.14 - 4 * np.pi]]])
    assert climbed(turned, [1, 1, 1], [(0, [0.0])], joints)[0] == 2
    assert climbed(turned, [1, 0, 1], [(0, [0.0])], joints)[0] == 0


def test_states_with_other_turns_are_others_and_more_than_there_is_room_for_are_left_out():
    wide = np.array([[0.0], [-20.0], [20.0], [1.0]])
    solutions = np.array([[[0.0]], [[0.1]]])
    starts = [(0, [2 * np.pi * k]) for k in (-2, -1, 0, 1, 2)]
    _, _, numbers = climbed(solutions, [1, 1], starts, wide)
    assert numbers[1, lay.ALIVE] == 5
    _, states, numbers = climbed(solutions, [1, 1], starts, wide, most=5)
    assert numbers[1, lay.ALIVE] == 5
    assert np.ptp(states[1, :, lay.VALUES]) == pytest.approx(8 * np.pi)
