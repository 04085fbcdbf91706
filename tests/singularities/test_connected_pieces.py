"""Pieces of leaves: those of one relation are counted on a grid, whatever follows from it."""

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.trig_relations import Factor, Relation
from robust_ik.singularities.families import connected_pieces
from robust_ik.singularities.families.connected_pieces import count_components
from robust_ik.singularities.families.leaf import Leaf, Pin
from robust_ik.singularities.geometry.screw_chain import ScrewChain

TURN = 2 * np.pi
Q1, Q2, Q3, Q4 = (Angle((joint,), (1,), TURN) for joint in range(4))


@pytest.fixture(scope="module")
def chain():
    return ScrewChain.of(rik.load("almarkhi_4dof"))


def leaf(pins, at, angle=Q2):
    """cos = at, and pins: a leaf in form only, which need not be singular."""
    terms = ((Factor(angle, "cos", 1.0),), (Factor(Q4, "cos", 1.0),), ())
    relation = Relation(terms, np.array([1.0, 0.2, -at]), 0.0, 10)
    return Leaf(1, 1, tuple(pins), (relation,), (), (), np.zeros((1, 4)))


@pytest.mark.parametrize("at, pieces", [(0.0, 2), (0.5, 2), (0.9, 1), (1.1, 1)])
@pytest.mark.parametrize(
    "pins",
    [
        (),
        (Pin(Q1, 0.3),),
        (Pin(Angle((1, 2), (1, -1), TURN), 0.7),),
        (Pin(Q1, -2.0), Pin(Angle((1, 2), (1, 1), TURN), 0.0)),
        (Pin(Angle((0, 2, 3), (1, -1, 1), TURN), 0.7), Pin(Q1, 1.0)),
    ],
)
def test_a_joint_that_follows_by_a_pinned_sum_changes_no_pieces(chain, pins, at, pieces, monkeypatch):
    monkeypatch.setattr(connected_pieces, "_linked", lambda *_: pytest.fail("walked"))
    assert count_components(chain, leaf(pins, at), np.random.default_rng(0)) == (pieces, False)


@pytest.mark.parametrize(
    "pins",
    [
        (Pin(Angle((1, 3), (1, -1), TURN), 0.7),),  # both joints of the relation
        (Pin(Angle((0, 2), (1, -1), TURN), 0.7),),  # neither: one of the two is free
        (Pin(Angle((1, 2), (1, -1), TURN), 0.7), Pin(Angle((2, 3), (1, 1), TURN), 0.1)),  # one joint follows twice
        (Pin(Angle((1, 3), (1, -1), TURN), 0.7), Pin(Angle((0, 2), (1, 1), TURN), 0.1)),  # no follower, and two
    ],
)
def test_pieces_are_walked_where_sums_bind_more_or_less(chain, pins, monkeypatch):
    monkeypatch.setattr(connected_pieces, "_linked", lambda *_: 7)
    assert count_components(chain, leaf(pins, 0.5), np.random.default_rng(0)) == (7, False)


def test_a_relation_in_a_pinned_joint_is_taken_at_its_value(chain, monkeypatch):
    """cos q1 + 0.2 cos q4 = 0.1: two places of q4 at q1 = 90°, none at q1 = 0, where nothing is left but to walk."""
    monkeypatch.setattr(connected_pieces, "_linked", lambda *_: 7)
    upright, along = (leaf((Pin(Q1, value),), 0.1, Q1) for value in (np.pi / 2, 0.0))
    assert count_components(chain, upright, np.random.default_rng(0))[0] == 2
    assert count_components(chain, along, np.random.default_rng(0))[0] == 7
