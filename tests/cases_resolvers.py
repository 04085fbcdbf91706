"""Every resolver with every way to meet limits, and families of random problems, for the tests that hold for all."""

import itertools

import numpy as np

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.inverses.task_equation import TaskEquation

LIMITERS = [
    rik.Sliding(),
    rik.Saturation(),
    rik.QuadraticProgram(),
    rik.QuadraticProgram(keep_direction=True),
    rik.Scaling(),
]
INVERSES = [rik.JParse(), rik.DampedLeastSquares(), rik.Chiaverini()]
STRICT = [
    resolver(inverse, limiter)
    for resolver, inverse, limiter in itertools.product(
        (rik.TaskPriority, rik.DecoupledPriority, rik.TaskReconstruction), INVERSES, LIMITERS
    )
]
RESOLVERS = STRICT + [
    *(kind(steady=True) for kind in (rik.TaskPriority, rik.TaskReconstruction, rik.WeightedPriority)),
    rik.WeightedPriority(),
    rik.WeightedPriority(rik.Chiaverini(), weights=(1.0,)),
    rik.TaskPriority((rik.SDLS(), rik.JParsePositionFirst(linear_rows=0), rik.Halley())),
    rik.TaskPriority(rik.MoorePenrose()),
    rik.TaskPriority(rik.FilteredInverse(rate=5.0)),
    rik.TaskPriority(rik.SecondOrder()),
    rik.TaskPriority(rik.SecondOrder(gamma=0.3, speed=0.5, acceleration=5.0), rik.QuadraticProgram()),
]

SMALL_SIGMAS = [0.0, 1e-14, 1e-9, 1e-4]
NEARNESS = [0.0, 1e-12, 1e-9, 1e-6, 1e-3]
"""How far a lower level is from a combination of the rows above."""

KINDS = ("regular", "kinematic", "algorithmic", "zero", "tall", "repeated", "copy")
BOXES = ("free", "inside", "outside", "locked", "rows", "on a bound")


def random_matrix(rng, m, n, small=None, repeated=False):
    """A random (m, n) matrix, its last singular value `small` if given, or all of them equal."""
    k = min(m, n)
    s = np.ones(k) if repeated else np.sort(rng.uniform(0.3, 2.0, k))[::-1]
    if small is not None:
        s[-1] = small
    U, V = np.linalg.qr(rng.normal(size=(m, k)))[0], np.linalg.qr(rng.normal(size=(n, k)))[0]
    return (U * s) @ V.T


def random_equation(rng, J, speed=1.0):
    xdot = speed * rng.normal(size=len(J))
    hessian = 0.3 * rng.normal(size=(len(J), J.shape[1], J.shape[1]))
    return TaskEquation(J, xdot, 0.1 * xdot, hessian)


def random_levels(rng, n, levels=None, kind=None, speed=None):
    """One to four levels, regular, at a kinematic or an algorithmic singularity or near to it, zero, tall, repeated."""
    found = []
    for index in range(levels or int(rng.integers(1, 5))):
        this = kind or KINDS[rng.integers(len(KINDS))]
        m = int(rng.integers(1, min(n, 7) + 1))
        if this == "tall":
            J = rng.normal(size=(int(rng.integers(n, 8)) if n < 7 else 7, n))
        elif this == "zero":
            J = np.zeros((m, n))
        elif this == "kinematic":
            J = random_matrix(rng, m, n, small=rng.choice(SMALL_SIGMAS))
        elif this in ("algorithmic", "copy") and index:
            above = np.concatenate([each.J for each in found])
            mix = rng.normal(size=(m, len(above))) if this == "algorithmic" else np.eye(len(above))[:m]
            J = mix @ above
            J = J + rng.choice(NEARNESS) * rng.normal(size=J.shape)
        else:
            J = random_matrix(rng, m, n, repeated=this == "repeated")
        found.append(random_equation(rng, J, speed or rng.choice([0.01, 1.0, 100.0])))
    return tuple(found)


def random_bounds(rng, n, kind=None):
    """No bounds; at rest inside; joints that must move; joints that must not; rows besides; at rest on a bound."""
    kind = kind or BOXES[rng.integers(len(BOXES))]
    if kind == "free":
        return Bounds.free(n)
    lower, upper = -rng.uniform(0.1, 2.0, n), rng.uniform(0.1, 2.0, n)
    some = rng.random(n) < 0.4
    if kind == "outside":
        upper = np.where(some, -rng.uniform(0.01, 0.1, n), upper)
    elif kind == "locked":
        lower, upper = np.where(some, 0.0, lower), np.where(some, 0.0, upper)
    elif kind == "on a bound":
        lower, upper = np.where(some, 0.0, lower), np.where(~some & (rng.random(n) < 0.4), 0.0, upper)
    box = named_box(lower, upper)
    if kind != "rows":
        return box
    count = int(rng.integers(1, 5))
    rows = rng.normal(size=(count, n))
    floor = rng.choice([-1.0, 0.0, -0.2, 0.05], count)
    return Bounds.of_rows(rows, floor, tuple(f"pair{i}" for i in range(count))).within(box)


def named_box(lower, upper):
    names = [f"joint{i}" for i in range(len(lower))]
    return Bounds(
        np.asarray(lower, dtype=float),
        np.asarray(upper, dtype=float),
        np.array([f"{name} lower" for name in names]),
        np.array([f"{name} upper" for name in names]),
    )


def random_problem(rng, levels=None, kind=None, bounds=None, n=None, speed=None):
    n = n or int(rng.integers(1, 10))
    return VelocityProblem(random_levels(rng, n, levels, kind, speed), random_bounds(rng, n, bounds))
