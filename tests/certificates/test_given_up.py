"""A case split is given up early only where it could not become complete, or no better than what is at hand."""

import time
from dataclasses import replace

import pytest

import robust_ik as rik
from robust_ik.certificates.certify import best_proof
from robust_ik.certificates.effort import Effort
from robust_ik.certificates.proof.proof import Proof
from robust_ik.certificates.prover.case_split import FEW, HOPELESS, _Splitter
from robust_ik.certificates.prover.exact_arm import exact_arm

ARMS = ("duleba_3r", "planar_3r", "almarkhi_4dof", "puma560", "pa10", "srs_7r", "ur5", "z1", "so100")
BUDGETS = (300, 3_000, 10_000, 20_000, 30_000, 60_000)


def proof(name: str, corank: int, effort: Effort) -> Proof:
    arm = exact_arm(rik.load(name, "jaw" if name == "so100" else None), 1e-4)
    return best_proof(arm, corank, time.monotonic() + 600, effort)


def quick(steps: float) -> Effort:
    return replace(Effort.quick(6), steps=steps)


@pytest.mark.parametrize("name", ARMS)
def test_a_split_that_is_given_up_would_not_have_become_complete(name, monkeypatch):
    whole = [proof(name, 2, replace(quick(steps), whole=True)) for steps in BUDGETS]
    soon = [proof(name, 2, quick(steps)) for steps in BUDGETS]
    monkeypatch.setattr(_Splitter, "_given_up", lambda self: not self.waiting)
    every = [proof(name, 2, replace(quick(steps), whole=True)) for steps in BUDGETS]
    ranks = ("proved", "implicit", "open")
    for one, other, early in zip(whole, every, soon):
        assert one.status == other.status
        assert ranks.index(early.status) <= ranks.index(one.status)


def test_many_cases_that_wait_end_a_split_before_its_steps_do(monkeypatch):
    left, treat = [], _Splitter._treat
    monkeypatch.setattr(_Splitter, "_treat", lambda self, state: left.append(self.effort.steps) or treat(self, state))
    found = proof("ur5", 2, quick(60_000))
    assert found.status == "open"
    assert left[-1] > 3_000
    assert len(left) < len(found.nodes)
    assert {node.reason for node in found.nodes if node.kind == "open"} == {"too large: no steps are left"}


def test_a_case_that_stays_open_ends_quick_work_and_not_thorough_work():
    short, long = proof("so100", 3, Effort.quick(6)), proof("so100", 3, replace(Effort.quick(6), whole=True))
    assert short.status == long.status == "open"
    assert any(node.reason == "another case is open or implicit" for node in short.nodes)
    assert not any(node.reason == "another case is open or implicit" for node in long.nodes)
    assert Effort.thorough().whole


def test_a_split_whose_cases_grow_faster_than_its_steps_allow_is_given_up_while_many_are_left():
    soon = proof("srs_10r", 1, Effort.quick(10))
    late = replace(Effort.quick(10), whole=True)
    assert soon.status == proof("srs_10r", 1, late).status == "open"
    looked_at = [node for node in soon.nodes if node.reason != "too large: no steps are left"]
    assert 20 < len(looked_at) < 0.5 * len(soon.nodes)


def test_a_proof_that_needs_nearly_all_of_its_steps_is_not_given_up(monkeypatch):
    """The hardest one of quick work: what waits would cost more than is left at the mean, and less than twice that."""
    ratios, given_up = [], _Splitter._given_up

    def noted(self):
        if self.treated >= FEW and self.waiting:
            mean = (self.allowed - self.effort.steps) / self.treated
            ratios.append(len(self.waiting) * mean / self.effort.steps)
        return given_up(self)

    monkeypatch.setattr(_Splitter, "_given_up", noted)
    effort = Effort.quick(10)
    assert proof("srs_10r", 3, effort).status == "proved"
    assert effort.steps < 0.1 * Effort.quick(10).steps
    assert 1.2 < max(ratios) < 1.5 < HOPELESS
