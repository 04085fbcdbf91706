"""Kim, Marani, Chung, Yuh: all kinds of singularity avoidance in redundant manipulators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import robust_ik as rik
from benchmarks.claims.claim import Claim
from benchmarks.claims.spread import spread
from robust_ik.checks import Array
from robust_ik.simulation.scenarios import load_scenario

KIND = "link lengths, circle's place and period, gain: stand-ins"
KIM, CHIAVERINI = "task reconstruction", "Chiaverini"


def claims() -> list[Claim]:
    """Every claim, in the paper's order."""
    circle = load_scenario("kim_circle")
    kim, chiaverini = (rik.simulate(circle, label) for label in (KIM, CHIAVERINI))
    return [*figures_3_and_4(kim, chiaverini), *recovery(kim, chiaverini), lost(), *two_tasks(), sign(), step()]


def halves(scenario: rik.Scenario) -> tuple[float, ...]:
    """Half of m̄, by level."""
    return tuple(bound / 2 for bound in scenario.methods[KIM].bounds)


def figures_3_and_4(kim: rik.Trajectory, chiaverini: rik.Trajectory) -> list[Claim]:
    """Measures, joint speeds and largest errors of the circle."""
    least = {"kim": kim.manipulability.min(), "chiaverini": chiaverini.manipulability.min()}
    error = {"kim": 1e3 * kim.position_error.max(), "chiaverini": 1e3 * chiaverini.position_error.max()}
    speeds = {"kim": kim.largest_speed, "chiaverini": chiaverini.largest_speed}
    return [
        Claim(
            "Fig. 3c: the measure is held at m̄/2", "0.03", {**least, "half": halves(load_scenario("kim_circle"))[0]},
            "{kim:.4f}", "abs(kim - half) < 0.01 * half", "and does not depend on lengths",
        ),
        Claim(
            "Fig. 4c: Chiaverini's measure gets small", "small", least, "{chiaverini:.4f}", "chiaverini < kim / 10",
            kind=KIND,
        ),
        Claim(
            "Fig. 4d: Chiaverini's joint speeds are larger", "about two times",
            {**speeds, "ratio": chiaverini.largest_speed / kim.largest_speed},
            "{ratio:.1f} times ({chiaverini:.1f} and {kim:.1f} rad/s)", "1.5 < ratio < 3 and chiaverini > kim",
            kind=KIND,
        ),
        Claim(
            "Figs. 3b, 4b: the largest errors are almost the same", "almost the same", error,
            "{kim:.1f} and {chiaverini:.1f} mm", "abs(kim - chiaverini) < 0.05 * chiaverini",
            "both are what the reach leaves out",
        ),
    ]  # fmt: skip


def recovery(kim: rik.Trajectory, chiaverini: rik.Trajectory) -> list[Claim]:
    """How the tool gets back onto the circle."""
    return [
        Claim(
            "Figs. 3b, 4b: the task recovers sooner", "around t = 2.2 s",
            {"kim": recovered(kim), "chiaverini": recovered(chiaverini)},
            "below 1 mm from {kim:.2f} s on, Chiaverini's from {chiaverini:.2f} s on", "kim < chiaverini", kind=KIND,
        ),
        Claim(
            "Figs. 3b, 4b: it recovers without over- and undershoot, Chiaverini's does not", "immediately",
            {"kim": overshoot(kim), "chiaverini": overshoot(chiaverini)},
            "in x the tool passes its target by {kim:.2f} mm, Chiaverini's by {chiaverini:.2f} mm",
            "kim < 0.01 and chiaverini > 1", kind=KIND,
        ),
    ]  # fmt: skip


def recovered(run: rik.Trajectory) -> float:
    """When the error is last above 1 mm, s."""
    return float(run.time[np.flatnonzero(run.position_error > 1e-3)[-1]])


def overshoot(run: rik.Trajectory) -> float:
    """How far the tool passes its target in x after it was out of reach, mm."""
    back = run.error[run.error[:, 0].argmax() :, 0]
    return float(max(0, -1e3 * back.min()))


def lost() -> Claim:
    """What the paper's introduction warns of."""
    circle = load_scenario("kim_circle")

    def plain(q0: Array) -> dict[str, float]:
        run = rik.simulate(replace(circle, q0=q0), "pseudo-inverse")
        return {"speed": run.largest_speed, "off": run.position_error.max()}

    return Claim(
        "without any of it the robot leaves the task", "must go away from our desire", spread(plain, circle.q0),
        "pseudo-inverse: {speed:.0e} rad/s, {off:.1f} m off", "speed > 100 and off > 0.2", "the target is out of reach",
    )  # fmt: skip


def two_tasks() -> list[Claim]:
    """Figure 5, and the equation behind it."""
    scenario = load_scenario("kim_two_tasks")
    kim, printed, decoupled = (
        rik.simulate(scenario, label) for label in (KIM, "as printed, drift left out", "Chiaverini, decoupled")
    )

    def thrown(q0: Array) -> float:
        return rik.simulate(replace(scenario, q0=q0), "task priority, pseudo-inverse").largest_speed

    first, second = kim.manipulability.min(axis=0)
    reached = float(printed.manipulability[:, 1].min())
    half1, half2 = halves(scenario)
    return [
        Claim(
            "Fig. 5: robust at kinematic and algorithmic singularities", "robustly performed",
            {"m1": first, "m2": second, "half1": half1, "half2": half2,
             "kim": kim.largest_speed, "decoupled": decoupled.largest_speed,
             "plain": spread(thrown, scenario.q0, count=2), "beyond": 1e4},
            "m₁ ≥ {m1:.4f}, m₂ ≥ {m2:.4f}, {kim:.1f} rad/s; Chiaverini decoupled {decoupled:.0f}, pseudo-inverse "
            "beyond {beyond:.0e} rad/s",
            "m1 > 0.99 * half1 and m2 > 0.99 * half2 and kim < decoupled < beyond < plain",
            "with the drift that eq. (26) leaves out; Fig. 5 compares with nothing", f"{KIND}, m̄₂ is ours too",
        ),
        Claim(
            "eq. (26): δm₂ comes from the second task alone", "so m₂ ≥ m̄₂/2",
            {"printed": reached, "counted": second, "half": half2},
            "m₂ falls to {printed:.2f}, m̄₂/2 is {half:.2f}", "printed > 0.99 * half",
            "the first task moves m₂ too; counted as drift, m₂ stays above {counted:.4f}",
        ),
    ]  # fmt: skip


def sign() -> Claim:
    """The last term of (22), from a measure far below m̄/2 and with nothing asked of the tool."""
    robot, stay, q = rik.load("planar_3r"), rik.TwistTask(np.zeros(6)), np.array([0.3, 0.05, 0.05])
    corrected = rik.TaskReconstruction(rik.MoorePenrose(), bound=0.06)
    up = rik.simulate(robot, corrected, stay, q, duration=1.0, dt=2e-3, calm=False).manipulability[:, 0]
    printed = replace(corrected, printed_sign=True)
    down = rik.simulate(robot, printed, stay, q, duration=0.1, dt=1e-4, calm=False).manipulability[:, 0]
    return Claim(
        "eq. (22): the last term leads back up below m̄/2", "m rises",
        {"begin": up[0], "printed": down.min(), "turned": up[-1]},
        "from {begin:.4f}: as printed to below {printed:.0e}, with the sign turned to {turned:.4f}",
        "printed >= begin", "it must be subtracted from the correction",
    )  # fmt: skip


def step() -> Claim:
    """The paper's guarantee, at steps longer than its own."""
    scenario = load_scenario("kim_circle")
    runs = [rik.simulate(replace(scenario, dt=dt), KIM) for dt in (0.01, 0.02)]
    fine, coarse = (float(each.manipulability.min()) for each in runs)
    return Claim(
        "the distance from a singularity stays above a lower limit", "guaranteed",
        {"fine": fine, "coarse": coarse, "half": halves(scenario)[0]},
        "{fine:.4f} at 100 Hz, {coarse:.4f} at 50 Hz", "fine > 0.99 * half and coarse > 0.9 * half",
        "up to the length of a step",
    )  # fmt: skip
