"""Every public function, class and method with values that nobody should pass: errors that are meant, or good results.

Which names there are, and which parameters they take, is read from the package; a new name that the samples below do
not cover is a failure, so that it cannot be forgotten.
"""

import contextlib
import dataclasses
import enum
import inspect
import math
import os
import tempfile
import warnings
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

import robust_ik as rik
from robust_ik import certificates, display, inverses
from robust_ik.analysis import evaluation, stability
from robust_ik.description.catalog import catalog
from robust_ik.simulation.robustness import BenchmarkResults, RunKey, RunScore
from tests.attack.guards import TooSlowError, within

COUNTS = {"short": 600, "full": 200_000}
CHUNK = 5_000
LIMITED = False  # what compiles maps more

MOST_SECONDS = 60.0
"""For one call: some sample searches, on a busy machine, or compiles."""

RECORDS = {
    "Explanation", "WayOut", "PoseResult", "PoseResults", "Resolution", "LevelResult", "NewtonResult", "Trajectory",
    "Stratum", "SingularityAtlas", "WorkspaceMap", "Cells", "PairDistance", "IgnoredPair", "PoseSolver", "Robot",
    "CollisionLimit",
    "JointLimits", "Ablation", "Card", "Jump", "TrackingReport", "Comparison", "ProofLeaf", "LeafPlace", "Proof",
    "JointRelation",    "Box", "Sphere", "Cylinder", "Verdict", "DrawnRobot", "MissingMesh", "Certificate",
    "Standstill", "SearchEnds", "Descent", "AllSolutions", "ManySolutions", "SelfMotion", "BranchSolver",
    "PathPlan", "PathPiece", "PathStop", "PathPlanner", "DrawnConfiguration", "LiveView",
}  # fmt: skip
"""What the package makes and hands out; their constructors are for it alone."""

LEFT_OUT = {
    "warmup": "compiles everything",
    "where": "of formulas of gains, which are compiled",
    "Stack": "a name for a type",
    "view": "opens a page with threads of its own: tests/display/test_live_view.py tries it with bad arguments",
}
PLUMBING = {
    "TaskEquation", "Settled", "Wish", "VelocityProblem", "Quantity", "VelocityLevel", "Description", "Visualizer",
    "Arm", "Bounds", "Unkept",
}  # fmt: skip
"""Types that only parts of the package pass to each other, or whoever writes a new part."""
PIECES = {"inverse_of", "factors", "squared_damping", "level", "levels", "damping_for", "peak", "gains_of"}
"""Methods that are parts of a method's own formula."""
PLUG_IN = PIECES | {"bounds", "spare", "formula", "equation", "feed", "begin", "velocity", "motion", "limit", "resolve"}
"""Methods that the package calls, with what it has checked already."""
WORK = {
    "starts",
    "count",
    "size",
    "max_iterations",
    "threads",
    "rounds",
    "solutions",
    "poses",
    "time_limit",
    "duration",
}
"""Parameters that say how much work is to be done: a great number is no mistake."""
CALLED = ("Callable", "Told", "Function", "Motion", "Path")
"""Annotations of what is called: what a callable of the user's raises is the user's."""


# ------------------------------------------------------------------------------------------------ good values
@cache
def arm():
    return rik.load("panda")


@cache
def small():
    return rik.load("planar_2r")


@cache
def atlas():
    return rik.find_singularities(small(), starts=20)


@cache
def run():
    return rik.simulate(small(), rik.JParse(), rik.Follow(line()), small().rest, duration=0.05)


@cache
def workspace():
    return rik.map_workspace(small(), 50)


@cache
def benchmark_results():
    key = RunKey("planar_2r", "cross", "first")
    numbers = dict.fromkeys([each.name for each in dataclasses.fields(RunScore)[:-1]], 0.5)
    told = {"exit": "fold", "place": "q2 = 0", "dt": 0.01, "seconds": 2.0}
    return BenchmarkResults({key: told}, {"a": {key: RunScore(**numbers, curves=((0.1, 0.2),) * 3)}})


def line():
    start = small().pose(small().rest)
    return rik.Line(start, start[:3, 3] + [0.05, 0.0, 0.0])


def table():
    return rik.DHTable((rik.DHJoint(a=0.3, d=0.1, alpha=0.5), rik.DHJoint(a=0.2, d=0.0, alpha=0.0)), "standard")


def identity():
    return np.eye(4)


Q = np.array([0.1, -0.5, 0.2, -1.8, 0.3, 1.5, 0.4])
SAMPLES = {
    "J": lambda: arm().jacobian(Q),
    "hessian": lambda: arm().hessian(Q),
    "xdot": lambda: np.full(6, 0.1),
    "twist": lambda: np.full(6, 0.1),
    "twists": lambda: np.full((3, 6), 0.1),
    "error": lambda: np.full(6, 0.1),
    "u": lambda: np.eye(6)[0],
    "gains": lambda: np.full(6, 2.0),
    "s": lambda: np.array([1.5, 0.9, 0.5, 0.2, 0.1, 0.01]),
    "q": lambda: Q,
    "q0": lambda: Q,
    "speed_limits": lambda: np.full(7, 2.0),
    "dq": lambda: np.full(7, 0.01),
    "qdot": lambda: np.full(7, 0.01),
    "theta": lambda: np.zeros((7, 6)),
    "q_from": lambda: Q,
    "q_to": lambda: Q + 0.1,
    "values": lambda: Q,
    "secondary": lambda: np.full(7, 0.1),
    "target": lambda: arm().pose(Q),
    "targets": lambda: np.stack([arm().pose(Q)] * 2),
    "T_world_tool": identity,
    "T_world_target": identity,
    "start": identity,
    "centre": lambda: np.array([0.1, 0.0, 0.0]),
    "normal": lambda: np.array([0.0, 0.0, 1.0]),
    "goal": lambda: np.array([0.3, 0.1, 0.2]),
    "amplitude": lambda: np.array([0.1, 0.0, 0.0]),
    "poses": lambda: np.stack([np.eye(4)] * 2),
    "axis": lambda: np.array([0.0, 0.0, 1.0]),
    "direction": lambda: np.array([1.0, 0.0, 0.0]),
    "times": lambda: np.array([0.0, 0.5, 1.0]),
    "A": lambda: np.eye(3) * 2,
    "M": lambda: np.eye(3) * 0.1,
    "extents": lambda: np.full(6, 1.0),
    "squared_damping": lambda: np.array(0.01),
    "size": lambda: 3,
    "joints": lambda: "panda_joint1",
    "base": lambda: "planar",
    "frame": lambda: "panda_link3",
    "root": lambda: "panda_link1",
    "rows": lambda: ("x", "y", "z"),
    "robot": lambda: small(),
    "inverse": lambda: rik.DampedLeastSquares(),
    "resolver": lambda: rik.JParse(),
    "controller": lambda: rik.VelocityController(small()),
    "scenarios": lambda: short_scenario(),
    "scenario": lambda: "xarm7_line",
    "methods": lambda: {"a": rik.JParse()},
    "stack": lambda: rik.PostureTask(Q),
    "limits": lambda: rik.JointLimits.of(arm()),
    "rng": lambda: np.random.default_rng(0),
    "path": lambda: "out.json",
    "name": lambda: "a",
    "label": lambda: "J-PARSE",
    "shape": lambda: rik.Sphere(0.1),
    "quantity": lambda: "manipulability",
    "axes": lambda: ("x", "z"),
    "convention": lambda: "standard",
    "stratum": lambda: atlas().strata[0],
    "atlas": lambda: atlas(),
    "proof": lambda: atlas().certificate.proofs[0],
    "certificate": lambda: atlas().certificate.proofs[0],
    "runs": lambda: {"a": run()},
    "run": lambda: run(),
    "trajectories": lambda: {"a": run()},
    "workspace": lambda: workspace(),
    "results": lambda: benchmark_results(),
    "summaries": lambda: benchmark_results().summaries(),
    "folder": lambda: "pages",
    "filters": lambda: [rik.JParse()],
    "scene": lambda: display.Scene(),
    "visualizer": lambda: display.Scene()["robot"],
    "configurations": lambda: {"a": small().rest},
    "status": lambda: rik.Status.TRACKING,
    "gain": lambda: np.array(1.0),
    "points": lambda: np.eye(3),
    "basis": lambda: np.eye(6)[:, 3:],
}
OWN = {
    "PositionTask": {"target": lambda: np.array([0.3, 0.0, 0.5])},
    "OrientationTask": {"target": lambda: np.eye(3)},
    "PostureTask": {"target": lambda: Q},
    "JointTask": {"target": lambda: 0.1},
    "RelativeTask": {"frame": lambda: "panda_link5"},
    "DampingTask": {"joints": lambda: ("panda_joint1",)},
    "Turning": {"path": lambda: line(), "goal": lambda: np.eye(3)},
    "Follow": {"path": lambda: line()},
    "Box": {"size": lambda: (0.1, 0.2, 0.3)},
    "DHTable": {"joints": lambda: table().joints},
    "load": {"robot": lambda: "planar_2r"},
    "newton": {
        "kinematics": lambda: lambda q: small().pose(q)[[0, 2], 3],
        "jacobian": lambda: lambda q: small().jacobian(q),
        "q0": lambda: small().rest,
        "target": lambda: np.array([0.3, 0.2]),
    },
    "simulate": {
        "motion": lambda: rik.Follow(line()),
        "q0": lambda: small().rest,
        "duration": lambda: 0.02,
    },
    "Scenario": {
        "q0": lambda: small().rest,
        "motion": lambda: rik.Follow(line()),
        "duration": lambda: 0.02,
    },
    "measure_bounds": {"robot": arm},
    "find_singularities": {"starts": lambda: 20, "certify": lambda: False},
    "gradient_search": {"corank": lambda: 1, "starts": lambda: np.array([[0.3, 1.0], [1.0, -2.0]])},
    "gradient_descent": {"corank": lambda: 1, "start": lambda: np.array([0.3, 1.0])},
    "map_workspace": {"count": lambda: 20},
    "certify": {"corank": lambda: 1, "time_limit": lambda: 5.0},
    "read_dh": {"path": lambda: scenario_robot()},
    "plot_gains": {"path": lambda: "out.png"},
    "plot_runs": {"path": lambda: "out.png"},
    "plot_workspace": {"path": lambda: "out.png"},
    "plot_curves": {"path": lambda: "out.png"},
    "descents_figure": {"descents": lambda: {}},
    "write_atlas_html": {"robot": small},
    "draw_configuration": {"robot": small, "q": lambda: small().rest},
    "draw_robot": {"robot": small, "q": lambda: small().rest},
    "allows_multiplicative_inverse": {"m": lambda: 6, "n": lambda: 7, "corank": lambda: 1},
    "conservative_gain": {"rows": lambda: 6},
    "Robot.from_urdf": {"path": lambda: str(urdf())},
    "Robot.from_dh": {"table": table},
    "Robot.joint_values": {"q": lambda: Q},
    "JointLimits.of": {"robot": arm},
    "CollisionLimit.of": {"robot": arm},
    "CollisionLimit.distances": {"robot": arm},
    "VelocityController": {"robot": arm},
    "Stepper": {"robot": arm},
    "SingularityAtlas.load": {"path": lambda: "there is none.json"},
    "SingularityAtlas.distance": {"q": lambda: small().rest},
    "SingularityAtlas.distances": {"q": lambda: small().rest},
    "SingularityAtlas.extended": {"starts": lambda: 20},
    "SingularityAtlas.of_corank": {"corank": lambda: 1},
    "WorkspaceMap.cells": {"size": lambda: 0.1},
    "DHTable.frames": {"q": lambda: np.zeros(2)},
    "DHTable.jacobian": {"q": lambda: np.zeros(2)},
    "DHTable.pose": {"q": lambda: np.zeros(2)},
    "Stepper.steps": {"q": lambda: np.stack([Q] * 3)},
    "JParse.from_limits": {"speed_limit": lambda: 2.0, "task_speed": lambda: 0.5},
    "Weighted": {"joint_weights": lambda: np.full(7, 2.0)},
    "Weighted.gains": {},
}
NUMBERS = {"float": 0.5, "int": 1, "bool": False, "str": "a"}


def short_scenario():
    return rik.Scenario("short", small(), small().rest, rik.Follow(line()), 0.02)


def scenario_robot():
    return next(str(entry.path) for entry in catalog().values() if entry.path.suffix == ".toml")


def urdf():
    return next(entry.path for entry in catalog().values() if entry.path.name == "panda.urdf")


# ------------------------------------------------------------------------------------------------ what is attacked
def instances():
    """Things whose methods are attacked, by the name of their class."""
    made = [arm(), rik.VelocityController(arm()), rik.Stepper(arm()), arm().pose_solver(), atlas(), run(), workspace()]
    made += [table(), rik.load_scenario("xarm7_line"), rik.JointLimits.of(arm()), rik.CollisionLimit.of(arm())]
    made += [rik.explain(arm().jacobian(Q), np.ones(6), rik.JParse()), arm().solve_pose(arm().pose(Q)), line()]
    made += [rik.Follow(line()), rik.Keypoints(np.stack([np.eye(4)] * 2), 1.0), rik.TwistCommand()]
    made += [rik.Replay(np.array([0.0, 1.0]), np.zeros((2, 6))), rik.OutAndBack(np.eye(4), np.ones(3))]
    made += [rik.Circle(np.eye(4), [0.1, 0, 0], [0, 0, 1]), rik.Sinusoid(np.eye(4), [0.1, 0, 0])]
    made += [rik.Turning(line(), np.eye(3)), rik.TaskPriority(), atlas().certificate, display.Scene()]
    for each in inverses.CLASSES:
        made.append(each(rik.JParse()) if "inverse" in required(each) else each())
    return made


def required(function):
    return [p.name for p in inspect.signature(function).parameters.values() if p.default is p.empty]


@cache
def subjects():
    """(name, what is called) of all that is attacked."""
    found = {}
    for module in (rik, inverses, evaluation, stability, certificates, display):
        for name in module.__all__:
            thing = getattr(module, name)
            if callable(thing) and name not in LEFT_OUT and name not in RECORDS and not _is_abstract(thing):
                found[name] = thing
    for owner in [*instances(), rik.Robot, rik.JointLimits, rik.CollisionLimit, rik.SingularityAtlas]:
        kind = owner if isinstance(owner, type) else type(owner)
        for name in dir(kind):
            method = inspect.getattr_static(kind, name)
            plain = isinstance(owner, type) and not isinstance(method, (classmethod, staticmethod))
            shown = not name.startswith("_") or (name == "__call__" and not isinstance(owner, type))
            if plain or not shown or name in PLUG_IN or isinstance(method, property):
                continue
            bound = getattr(owner, name)
            if callable(bound) and getattr(bound, "__module__", "").startswith("robust_ik"):
                found.setdefault(f"{kind.__name__}()" if name == "__call__" else f"{kind.__name__}.{name}", bound)
    return tuple((name, thing) for name, thing in found.items() if _is_for_people(thing))


def _is_abstract(thing):
    return isinstance(thing, type) and (
        issubclass(thing, (BaseException, enum.Enum))
        or inspect.isabstract(thing)
        or thing.__name__ in ("Task", "Limit")
    )


def _is_for_people(thing):
    return not any(
        any(word in str(parameter.annotation) for word in PLUMBING)
        for parameter in inspect.signature(thing).parameters.values()
    )


def sample(name, parameter):
    """A good value, or KeyError."""
    own = OWN.get(name, {}).get(parameter.name)
    if own is not None:
        return own()
    annotation = str(parameter.annotation)
    number = next((value for kind, value in NUMBERS.items() if annotation.split(" |")[0] == kind), None)
    if parameter.name in SAMPLES and not (number is not None and isinstance(number, float)):
        return SAMPLES[parameter.name]()
    if number is not None:
        return number
    return SAMPLES[parameter.name]()


def uncovered():
    """The parameters that no sample is for."""
    missing = []
    for name, thing in subjects():
        for parameter in _parameters(thing):
            try:
                if parameter.default is parameter.empty:
                    sample(name, parameter)
            except KeyError:
                missing.append(f"{name}: no sample for {parameter.name}: {parameter.annotation}")
    return missing


def _parameters(thing):
    kinds = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    return [p for p in inspect.signature(thing).parameters.values() if p.kind not in kinds]


# ------------------------------------------------------------------------------------------------ hostile values
class Liar:
    """Pretends to be an array, and is none."""

    def __array__(self, *_, **__):
        raise ValueError("no")

    def __repr__(self):
        return "Liar()"


def endless():
    """A list that holds itself."""
    held = []
    held.append(held)
    return held


def of_any_kind():
    return [
        None, "", "x", "\ud800", "\x00", "x" * 5000, b"x", True, False, math.nan, math.inf, -math.inf, 1e308, -1e308,
        1e-320, -1.0, 0, -0.0, -1, 2**63, 10**400, -(10**400), 1j, [], (), {}, set(), {1: 2}, object(), Liar(), int,
        np.array([]), np.zeros((0, 6)), np.zeros((3, 0)), np.full(6, np.nan), np.full(7, np.inf),
        np.full((6, 7), 1e308),
        np.full((6, 7), 1e-310), np.ones((6, 7), complex), np.array([object()], object), np.array(["a"]),
        np.array(["2020-01-01"], "datetime64[D]"), np.zeros(2, [("a", float)]),
        np.ma.masked_array(np.ones(6), np.eye(6)[0]),
        [[1.0], [1.0, 2.0]], [None] * 6, ["x", "x"], endless(), np.float64(np.nan), np.array(np.nan), np.int8(-3),
        Path("x"), range(3), np.random.default_rng(1), [np.nan] * 3, ("x", "y", "z", "x"), {"a": None}, {"a": 1.0},
    ]  # fmt: skip


def of_arrays(good):
    """What a good array may become; the last ones are as good."""
    size, one = good.shape, np.zeros(good.size)
    if good.size:
        one[good.size // 2] = 1.0
    where = one.reshape(size) > 0
    return [
        *(np.where(where, value, good) for value in (np.nan, np.inf, 1e308, -1e308, 1e160, 1e-320)),
        good * 1e308, good * 1e200, good * 1e-160, good * 0, np.full(size, 1e308),
        good[..., :-1] if good.ndim else [1.0, 2.0],
        good[None], good[None][:0], good.T, good.astype(complex), good.astype(object), good.astype(str),
        np.ma.masked_array(good, where), (each for each in good) if good.ndim else None,
        good.astype(np.float32), np.asfortranarray(good), good[..., ::-1][..., ::-1] if good.ndim else good,
        np.repeat(good, 2, axis=-1)[..., ::2] if good.ndim else good, good.tolist(), good.astype(int),
        good.astype(bool), good.astype(">f8"), good.astype(np.longdouble),
    ]  # fmt: skip


def hostile(parameter, good):
    values = of_any_kind()
    if isinstance(good, np.ndarray):
        with np.errstate(all="ignore"):
            values += of_arrays(good)
    if isinstance(good, str):
        values += [good + "\x1b", good.upper(), " " + good]
    annotation = str(parameter.annotation)
    if any(word in annotation for word in CALLED):
        values = [value for value in values if not callable(value)]
    if parameter.name in WORK:
        values = [value for value in values if not (isinstance(value, (int, float)) and value > 100)]
    return values


# ------------------------------------------------------------------------------------------------ the attack
def attack(count, seed, say):
    """What came out that may not: other errors, warnings, NaN."""
    failures, rng = uncovered(), np.random.default_rng(seed)
    names = subjects()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for index in range(count):
            name, thing = names[index % len(names)]
            failures += _one(name, thing, rng, say)
    return list(dict.fromkeys(failures))


def _one(name, thing, rng, say):
    parameters = _parameters(thing)
    if not parameters:
        return []
    try:
        given = {p.name: sample(name, p) for p in parameters if p.default is p.empty}
    except KeyError:
        return []  # is told once
    chosen = [parameters[i] for i in rng.permutation(len(parameters))[: 1 + (rng.random() < 0.2)]]
    for parameter in chosen:
        try:
            good = sample(name, parameter)
        except KeyError:
            good = None
        values = hostile(parameter, good)
        given[parameter.name] = values[rng.integers(len(values))]
    words = f"{name}({', '.join(f'{p.name}={_shown(given[p.name])}' for p in chosen)})"
    say(words)
    return [f"{words}: {reason}" for reason in _called(name, thing, given)]


def _called(name, thing, given):
    positional = [p.name for p in _parameters(thing) if p.kind is inspect.Parameter.POSITIONAL_ONLY]
    try:
        with warnings.catch_warnings(), within(MOST_SECONDS):
            warnings.simplefilter("error")
            result = thing(*(given.pop(each) for each in positional), **given)
        if hasattr(result, "close"):
            result.close()
    except rik.RobustIKError as error:
        return [] if str(error).strip() else ["an error without words"]
    except TooSlowError:
        return ["too slow"]
    except Exception as error:
        return [f"{type(error).__name__}: {str(error)[:150]} at {_place(error)}"]
    return _not_numbers(result, usual(name))


def _place(error):
    trace, place = error.__traceback__, "?"
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if "robust_ik" in file:
            place = f"{Path(file).name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place


@cache
def usual(name):
    """Where a good call has NaN: that is what stands for "none" there."""
    thing = dict(subjects())[name]
    try:
        result = thing(**{p.name: sample(name, p) for p in _parameters(thing) if p.default is p.empty})
    except rik.RobustIKError:
        return frozenset()
    if hasattr(result, "close"):
        result.close()
    return frozenset(_not_numbers(result, frozenset()))


def _not_numbers(result, allowed, path="result", depth=0):
    """NaN in a result, by where it is."""
    found = []
    if isinstance(result, float) and math.isnan(result):
        found = [f"NaN in {path}"]
    elif isinstance(result, np.ndarray) and result.dtype.kind in "fc":
        found = [f"NaN in {path}"] if np.isnan(result).any() else []
    elif depth < 3:
        if dataclasses.is_dataclass(result) and not isinstance(result, (type, rik.Robot, rik.RobustInverse)):
            parts = {f".{f.name}": getattr(result, f.name) for f in dataclasses.fields(result)}
        elif isinstance(result, Mapping):
            parts = {f"[{key!r}]": value for key, value in result.items()}
        elif isinstance(result, (tuple, list)):
            parts = {f"[{i}]": value for i, value in enumerate(result[:10])}
        else:
            parts = {}
        for key, value in parts.items():
            found += _not_numbers(value, allowed, path + key, depth + 1)
    return [each for each in found if each not in allowed]


def _shown(value):
    if isinstance(value, np.ndarray):
        return f"{type(value).__name__} {value.dtype} {value.shape} {value.ravel()[:3]}"
    try:
        return repr(value)[:60]
    except Exception:
        return type(value).__name__


if __name__ == "__main__":
    import sys

    os.environ.setdefault("MPLBACKEND", "agg")
    broken = attack(int(sys.argv[1]), int(sys.argv[2]), lambda text: None)
    print(*broken, sep="\n")
    sys.exit(bool(broken))
