"""What a case split remembers changes neither a proof nor the steps that it takes."""

import math

import pytest

import robust_ik as rik
from robust_ik.certificates.certify import certify_exact
from robust_ik.certificates.effort import Effort, OutOfStepsError
from robust_ik.certificates.prover import remembered
from robust_ik.certificates.prover.exact_arm import exact_arm
from robust_ik.certificates.prover.remembered import Memory


def effort(steps):
    return Effort(terms=400, degree=16, bits=1500, steps=steps)


@pytest.mark.parametrize("name", ["planar_3r", "duleba_3r", "puma560"])
def test_a_proof_is_the_same_without_memory(name, monkeypatch):
    arm = exact_arm(rik.load(name))
    proof = certify_exact(arm, 1, thorough=False)
    monkeypatch.setattr(remembered, "MOST", 0)
    assert certify_exact(arm, 1, thorough=False).to_json() == proof.to_json()


def test_a_result_is_worked_out_once_and_its_steps_are_spent_each_time():
    memory, left, calls = Memory(), effort(100), []

    def made():
        calls.append(None)
        left.spend(30)
        return "result"

    assert [memory.recall("key", left, made) for _ in range(3)] == ["result"] * 3
    assert (left.steps, len(calls)) == (10, 1)
    with pytest.raises(OutOfStepsError):
        memory.recall("key", left, made)


def test_what_was_too_large_is_tried_again():
    memory, calls = Memory(), []

    def made(left):
        calls.append(None)
        left.spend(30)
        return "result"

    for steps in (20, 20, 40):
        left = effort(steps)
        if steps == 20:
            with pytest.raises(OutOfStepsError):
                memory.recall("key", left, lambda left=left: made(left))
        else:
            assert memory.recall("key", left, lambda left=left: made(left)) == "result"
    assert len(calls) == 3


def test_without_a_limit_no_steps_are_counted():
    memory, left = Memory(), effort(math.inf)
    for _ in range(2):
        memory.recall("key", left, lambda: left.spend(5))
    assert left.steps == math.inf
