"""Random control steps on real robots, every promise about limits checked after each, then whole motions: `make soak`.

The motions are those of `tests.closed_loop`: to targets that stand still, until they rest. None may shake.
"""

import argparse
import copy
import functools
import itertools
import math
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from rich.progress import Progress

import robust_ik as rik
from robust_ik.control.compiled_loop.resolver_program import is_compilable
from robust_ik.control.limits import HalfSpace, Obstacle
from robust_ik.description.joint_tree import Box, Sphere
from tests import closed_loop
from tests.cases_resolvers import RESOLVERS, STRICT

ROBOTS = {
    "panda": {},
    "ur5": {},
    "xarm7": {},
    "kinova": {},  # continuous joints
    "tiago": {},  # a prismatic torso
    "pa10": {},  # no limits in its table but what we set here
    "planar_2r": {},  # more rows than joints
    "baxter": {"tip": "left_gripper", "whole_tree": True},  # two arms
}
TOLERANCE = 1e-9
CHECKED = 0.2
"""The share of steps that are taken once more with the first level alone."""

COLLIDING = 0.2
"""The share of runs that keep links from each other and from obstacles."""

RUN = 25
"""Steps of one run, from one start."""

CHUNK = 5_000
"""Steps that one process takes at a time, from a seed of their own: results do not depend on how many there are."""


def soak(robots, steps, seed, only="", colliding=None):
    """Runs of random resolvers, stacks, limits and starts; raises at the first broken promise.

    Args:
        robots: The robots, one after the other.
        steps: Number of steps.
        seed: Of everything random.
        only: Resolvers are drawn whose text has this in it.
        colliding: The share of runs that keep links from each other and from obstacles; default COLLIDING.

    Returns:
        How many steps went how, by status.
    """
    rng = np.random.default_rng(seed)
    counts = dict.fromkeys(rik.Status, 0)
    chosen = [each for each in RESOLVERS if only in str(each)]
    for _, robot in zip(range(0, steps, RUN), itertools.cycle(robots)):
        for status in one_run(robot, rng, chosen, colliding):
            counts[status] += 1
    return counts


def one_run(robot, rng, resolvers=RESOLVERS, colliding=None):
    """Statuses of a run; what broke a promise is in the message."""
    limits, near = random_limits(robot, rng), random_collisions(robot, rng, colliding)
    resolver = resolvers[rng.integers(len(resolvers))]
    q, stack = random_start(robot, limits, rng), random_stack(robot, rng)
    yield from kept_run(robot, rng, limits, near, resolver, q, stack, RUN)


def kept_run(robot, rng, limits, near, resolver, q, stack, steps):
    """Statuses of a run of so many steps from q, every promise checked."""
    strongest_first = [limits] if near is None else [limits, near] if rng.random() < 0.5 else [near, limits]
    dt = float(rng.choice([1e-3, 1e-2, 0.1]))
    controller = rik.VelocityController(robot, resolver, strongest_first)
    if rng.random() < 0.3:  # in motion, perhaps too fast to stop
        controller.reset(rng.normal(size=robot.n) * rng.choice([0.1, 1.0, 5.0]))
    bends = Bends(controller)
    for _ in range(steps):
        bends.seen = False
        before, driver, noted = controller.qdot, copy.deepcopy(controller._driver), controller.calming.memory.copy()
        step = controller.step(q, stack, dt)
        where = f"{robot.name}, {resolver}, q={q!r}"
        assert np.isfinite(step.qdot).all(), f"not finite: {where}"
        after = robot.integrate(q, dt * step.qdot)
        assert (np.abs(step.qdot) <= limits.velocity + TOLERANCE).all(), f"speed: {where}"
        out_before, out_after = (outside(robot, limits, each) for each in (q, after))
        assert (out_after <= np.maximum(out_before, 0) + TOLERANCE).all(), f"position: {where}"
        returning = (out_before > TOLERANCE) & (limits.velocity > 0)
        if np.isinf(limits.acceleration).all():
            assert (out_after[returning] < out_before[returning]).all(), f"return: {where}"
        too_much = np.abs(step.qdot - before) > limits.acceleration * dt + TOLERANCE
        for name in np.array(robot.joint_names)[too_much]:
            assert f"{name} acceleration" in step.contradictions, f"acceleration of {name}: {where}"
        for name in too_near(robot, near, q, before, dt, step.qdot):
            assert name in step.contradictions, f"distance of {name}: {where}"
        assert (step.status is rik.Status.INFEASIBLE) == bool(step.contradictions), f"status: {where}"
        assert ((step.scale >= 0) & (step.scale <= 1)).all(), f"shares: {where}"
        assert step.text.startswith(step.status.name.lower()), f"text: {where}"
        # What a collision limit asks for on seeing where a whole step ends depends on the levels in it.
        if resolver in STRICT and len(stack) > 1 and rng.random() < CHECKED and not bends.seen:
            first = rik.VelocityController(robot, resolver, strongest_first)
            first.reset(before)
            first._driver, first.calming.memory[:], bends_alone = driver, noted, Bends(first)  # with what it remembers
            alone = first.step(q, stack[:1], dt)
            if not bends_alone.seen:
                assert np.abs(step.residual - alone.residual).max() <= TOLERANCE, f"first level: {where}"
                assert abs(step.scale[0] - alone.scale[0]) <= 1e-6, f"scale of the first level: {where}"
        yield step.status
        q = after


class Bends:
    """Whether a limit has asked a controller for more on seeing where its step ends.

    Attributes:
        seen: Whether one has, since this was last set to False.
    """

    def __init__(self, controller):
        self.seen, self._tightened = False, controller.compiled.tightened
        controller.compiled.tightened = self

    def __call__(self, *given):
        tighter = self._tightened(*given)
        self.seen = self.seen or tighter is not None
        return tighter


def outside(robot, limits, q):
    """How far each joint is outside its limits, negative inside."""
    values = robot.joint_values(q)
    return np.maximum(values - limits.upper, limits.lower - values)


def random_limits(robot, rng):
    """The robot's own, sometimes with margins, accelerations, or a joint that must not move."""
    finite = np.minimum(robot.velocity_limit, 2.0)
    finite = np.where(rng.random(robot.n) < 0.02, 0.0, finite)
    span = np.minimum(robot.upper - robot.lower, 2.0)
    return rik.JointLimits.of(
        robot,
        velocity=finite,
        margin=rng.choice([0.0, 0.05, 0.2]) * span,
        acceleration=rng.choice([np.inf, 0.5, 5.0, 50.0]),
        recovery_speed=float(rng.choice([0.05, 0.5])),
    )


def random_collisions(robot, rng, share=None):
    """Mostly none; else the robot's own links and things that stand where it moves, sometimes in the middle of it."""
    if rng.random() >= (COLLIDING if share is None else share):
        return None
    distance, gain = float(rng.choice([0.0, 0.02])), float(rng.choice([10.0, 1e4]))
    return collisions_of(robot, int(rng.integers(4)), distance, gain)


@functools.lru_cache(maxsize=256)
def collisions_of(robot, place, distance, gain):
    rng, ball = np.random.default_rng(place), np.eye(4)
    ball[:3, 3] = rng.uniform(-0.6, 0.6, 3)
    box = np.eye(4)
    box[:3, 3] = rng.uniform(-0.6, 0.6, 3)
    standing = [
        Obstacle("floor", HalfSpace((0.0, 0.1, 1.0), -0.3)),
        Obstacle("ball", Sphere(0.12), ball),
        Obstacle("box", Box((0.2, 0.3, 0.1)), box),
    ]
    return rik.CollisionLimit.of(robot, obstacles=standing, distance=distance, gain=gain)


def too_near(robot, near, q, before, dt, qdot):
    """What approaches faster than it may."""
    if near is None:
        return []
    bounds = near.bounds(robot, q, before, dt)
    return [name for name, missing in zip(bounds.row_cause, bounds.floor - bounds.rows @ qdot) if missing > TOLERANCE]


def random_start(robot, limits, rng):
    """Inside, on a limit, outside, or in a configuration of right angles, which is often singular."""
    q = robot.joint_values(robot.random(rng))
    kind = rng.integers(5)
    if kind == 1:
        return robot.configuration(np.clip(np.where(rng.random(robot.n) < 0.5, limits.upper, limits.lower), -3, 3))
    if kind == 2:
        push = rng.normal(size=robot.n) * 0.3
        return robot.configuration(np.clip(q, limits.lower, limits.upper) + push)
    if kind == 3:
        return robot.configuration(np.clip(np.pi / 2 * rng.integers(-2, 3, robot.n), limits.lower, limits.upper))
    if kind == 4:
        return robot.rest
    return robot.configuration(np.clip(q, limits.lower, limits.upper))


def random_stack(robot, rng):
    """One to four levels of tasks, targets near and far, out of reach, contradicting each other."""
    frames = [robot.tip, robot.frames[int(rng.integers(1, len(robot.frames)))]]
    near = robot.pose(robot.random(rng), frames[0])
    far = near.copy()
    far[:3, 3] *= 10
    tasks = [
        rik.FrameTask(near, gain=float(rng.choice([0.5, 10.0]))),
        rik.FrameTask(far, gain=5.0, max_linear=0.3),
        rik.PositionTask(near[:3, 3], frame=frames[1]),
        rik.OrientationTask(near[:3, :3], gain=3.0, rows=("wx", "wy", "wz")),
        rik.PostureTask(robot.random(rng)),
        rik.PostureTask(robot.rest, max_speed=0.3),
        rik.TwistTask(rng.normal(size=6) * rng.choice([0.01, 1.0, 100.0])),
        rik.ManipulabilityTask(),
        rik.SingularValueTask(threshold=0.1),
        rik.DampingTask(),
        rik.JointRangeTask(),
        rik.DirectionTask([0, 0, 1], rng.normal(size=3), gain=3.0, max_angular=float(rng.choice([0.3, np.inf]))),
        rik.JointTask(robot.joint_names[-1], float(rng.uniform(-1, 1)), gain=5.0),
        rik.RelativeTask(frames[0], robot.description.root, near, gain=2.0, max_linear=0.5),
    ]
    levels = int(rng.integers(1, 5))
    return [[tasks[i] for i in rng.choice(len(tasks), int(rng.integers(1, 3)), replace=False)] for _ in range(levels)]


@functools.cache
def load_robots():
    return [rik.load(name, **how) for name, how in ROBOTS.items()]


def chunk(steps, seed, only="", colliding=None):
    return soak(load_robots(), steps, seed, only, colliding)


LOOPS = 50
"""Whole motions that one process takes at a time."""


def loops(count, seed, surroundings=closed_loop.SURROUNDINGS, until=math.inf):
    """How many motions of so many came to rest, arrived, still moved when time was up, and what shook or broke.

    Exact ones that still move are given LONGER. None is begun after a time of `time.time`.
    """
    rng, counts, broken = np.random.default_rng(seed), Counter(), []
    for _ in range(count):
        if time.time() >= until:
            break
        draw = closed_loop.draw(rng, surroundings=surroundings)
        ending = closed_loop.run(draw)
        creeps = not (draw.noisy or ending.chatters or ending.error < ARRIVED or ending.speed < closed_loop.REST)
        if creeps:
            ending = late(draw, ending)
        if ending.chatters:
            broken.append(f"shakes at {ending.speed:.3g}: {draw}")
        elif ending.error < ARRIVED:
            counts["arrived"] += 1
        elif draw.noisy:
            counts["elsewhere with noise, without shaking"] += 1
        elif ending.speed < closed_loop.REST:
            counts["creep, then rest elsewhere" if creeps else "rest elsewhere"] += 1
        else:
            counts["still on their way"] += 1
        if not draw.noisy and ending.outside > TOLERANCE:
            broken.append(f"outside by {ending.outside:.3g}: {draw}")
    return counts, broken


LONGER = 1200.0
"""How long an exact motion may creep before it rests, s."""


def late(draw, ending):
    """The ending of an exact motion that still moves after a minute, or twelve seconds in short steps."""
    if draw.surroundings == "collision":  # step by step
        return ending
    for seconds in (LONGER / 10, LONGER / 4, LONGER):
        ending = closed_loop.run(draw, seconds=seconds, steps=10**7)
        if ending.speed < closed_loop.REST:
            break
    return ending


ARRIVED = 1e-3
"""A motion has arrived that ends nearer than this, m."""


def soak_steps(wanted, seed, pool, only="", colliding=None):
    sizes = [min(CHUNK, wanted - done) for done in range(0, wanted, CHUNK)]
    seeds = np.random.SeedSequence(seed).spawn(len(sizes))
    counts, started = Counter(dict.fromkeys(rik.Status, 0)), time.perf_counter()
    with Progress() as bar:
        task = bar.add_task("steps", total=wanted)
        for size, found in zip(sizes, pool.map(chunk, sizes, seeds, *map(itertools.repeat, (only, colliding)))):
            counts.update(found)
            bar.update(task, advance=size)
    seconds = time.perf_counter() - started
    print(f"{sum(counts.values()):,} steps on {len(ROBOTS)} robots in {seconds:.0f} s, no promise broken")
    for status, count in counts.items():
        print(f"  {status.name.lower():<11}{count:>10,}")


def soak_loops(wanted, seed, pool, surroundings, minutes=math.inf):
    """The number of motions that shook or left the limits; no more are begun after so many minutes."""
    sizes = [min(LOOPS, wanted - done) for done in range(0, wanted, LOOPS)]
    seeds = np.random.SeedSequence(seed).spawn(len(sizes))
    counts, broken, started = Counter(), [], time.perf_counter()
    until = time.time() + 60 * minutes
    with Progress() as bar:
        task = bar.add_task("motions", total=wanted)
        tasks = [pool.submit(loops, size, each, surroundings, until) for size, each in zip(sizes, seeds)]
        for each, size in zip(tasks, sizes):
            found = each.result()
            counts.update(found[0])
            broken += found[1]
            if found[1]:
                print(*found[1], sep="\n", flush=True)
            bar.update(task, advance=size)
    made = sum(counts.values()) + sum(each.startswith("shakes") for each in broken)
    seconds = time.perf_counter() - started
    print(
        f"{made:,} motions of {len(closed_loop.ARMS)} arms ({', '.join(surroundings)}) in {seconds:.0f} s, "
        f"{len(broken)} shook or left the limits"
    )
    for name, count in counts.most_common():
        print(f"  {count:>10,} {name}")
    return len(broken)


SIDE_BY_SIDE, EACH = 50, 400
"""Runs from one stack, and steps of each."""


def prepared(steps, seed):
    """How many steps of prepared loops, many runs side by side, were made; what broke a limit is in the message."""
    rng, made = np.random.default_rng(seed), 0
    robots = itertools.cycle(load_robots())
    while made < steps:
        robot = next(robots)
        limits, resolver = random_limits(robot, rng), LOOPED[rng.integers(len(LOOPED))]
        dt = float(rng.choice([1e-3, 1e-2, 0.1]))
        loop = rik.ControlLoop(rik.VelocityController(robot, resolver, limits), random_stack(robot, rng), dt)
        if not loop.compiled:
            continue
        starts = np.array([random_start(robot, limits, rng) for _ in range(SIDE_BY_SIDE)])
        found = loop.runs(starts, EACH)
        check_runs(robot, limits, dt, starts, found, f"{robot.name}, {resolver}, dt {dt}, {loop.tasks}")
        made += SIDE_BY_SIDE * EACH
    return made


def check_runs(robot, limits, dt, starts, found, where):
    """Every promise about joint limits, for every step of many runs."""
    assert np.isfinite(found.qdot).all(), f"not finite: {where}"
    assert (np.abs(found.qdot) <= limits.velocity + TOLERANCE).all(), f"speed: {where}"
    q = np.concatenate([starts[:, None], found.q], axis=1)
    out = outside(robot, limits, q)
    assert (out[:, 1:] <= np.maximum(out[:, :-1], 0) + TOLERANCE).all(), f"position: {where}"
    before = np.concatenate([np.zeros_like(found.qdot[:, :1]), found.qdot[:, :-1]], axis=1)
    hurried = np.abs(found.qdot - before) > limits.acceleration * dt + TOLERANCE
    for run, step, joint in zip(*np.nonzero(hurried)):  # only where position or speed, which are stronger, need it
        bounds = limits.bounds(robot, q[run, step], before[run, step], dt)
        assert f"{robot.joint_names[joint]} acceleration" in bounds.contradictions, f"acceleration: {where}"


LOOPED = [each for each in RESOLVERS if is_compilable(each)]
"""Resolvers that a prepared loop may make in one call."""


def soak_prepared(wanted, seed, pool):
    sizes = [min(20 * CHUNK, wanted - done) for done in range(0, wanted, 20 * CHUNK)]
    counts, started = 0, time.perf_counter()
    with Progress() as bar:
        task = bar.add_task("prepared steps", total=wanted)
        for size, made in zip(sizes, pool.map(prepared, sizes, np.random.SeedSequence(seed).spawn(len(sizes)))):
            counts += made
            bar.update(task, advance=size)
    seconds = time.perf_counter() - started
    print(f"{counts:,} steps of prepared loops in {seconds:.0f} s, no promise broken")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--only", default="", help="steps only of resolvers with this in their text, as SecondOrder")
    parser.add_argument("--colliding", type=float, default=COLLIDING, help="share of these with collision limits")
    parser.add_argument("--prepared", type=int, default=10_000_000, help="steps of prepared loops, many side by side")
    parser.add_argument("--loops", type=int, default=20_000, help="whole motions")
    parser.add_argument(
        "--surroundings", nargs="+", choices=closed_loop.SURROUNDINGS, default=closed_loop.SURROUNDINGS,
        help="limits of the whole motions: those with collisions take a hundred times as long as the others",
    )  # fmt: skip
    parser.add_argument("--minutes", type=float, default=math.inf, help="whole motions are begun for so long")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    arguments = parser.parse_args()
    with ProcessPoolExecutor(arguments.jobs) as pool:
        if arguments.steps:
            soak_steps(arguments.steps, arguments.seed, pool, arguments.only, arguments.colliding)
        if arguments.prepared:
            soak_prepared(arguments.prepared, arguments.seed, pool)
        told = arguments.loops, arguments.seed, pool, arguments.surroundings, arguments.minutes
        return int(arguments.loops and soak_loops(*told) > 0)


if __name__ == "__main__":
    sys.exit(main())
