"""What is passed to public names by mistake is told in a sentence, and never comes out as NaN."""

import contextlib

import numpy as np
import pytest

import robust_ik as rik
from robust_ik import inverses
from robust_ik.analysis.stability import largest_stable_dt
from robust_ik.checks.public_arguments import check_type, checked, computed
from robust_ik.errors import InputError
from tests.attack import public_names


def test_every_public_name_is_attacked():
    assert public_names.uncovered() == []
    names = {name for name, _ in public_names.subjects()}
    assert {"explain", "simulate", "OutAndBack", "Robot.pose", "VelocityController.step", "Stepper.step"} <= names
    assert {"JParse.solve", "plot_runs", "largest_stable_gain", "SingularityAtlas.distance", "Follow()"} <= names


def test_hostile_values_are_told_in_a_sentence_or_give_good_results():
    assert public_names.attack(public_names.COUNTS["short"], 7, lambda text: None) == []


def test_a_function_that_fails_in_its_own_way_is_found():
    def divides(value: "float") -> float:
        return 1 / value

    found = [public_names._called("svd", divides, {"value": value}) for value in (0, "x")]
    assert [each[0].split(":")[0] for each in found] == ["ZeroDivisionError", "TypeError"]
    assert public_names._called("svd", lambda value: np.array([value]), {"value": np.nan}) == ["NaN in result"]


J, XDOT, POSTURE = np.eye(6), np.ones(6), rik.PostureTask([0.0, 0.0])


def newton(**changed):
    """Newton's iteration on the plane itself, changed."""
    plane = {"kinematics": lambda q: q, "jacobian": lambda q: np.eye(2), "hessian": lambda q: np.zeros((2, 2, 2))}
    return rik.newton(**plane | changed, inverse=rik.JParse(), q0=[0.0, 0.0], target=[1.0, 1.0])


@pytest.mark.parametrize("kind", inverses.CLASSES, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("size", [1e308, 1e-320])
def test_what_an_inverse_makes_of_numbers_at_the_ends_of_all_is_finite_or_refused(kind, size):
    inverse = kind(rik.JParse()) if "inverse" in public_names.required(kind) else kind()
    J = np.diag([1.0, 0.5, 0.3, 0.2, 0.1, 1e-3])
    J[0, 0] = size
    for wish in (np.ones(6), np.full(6, size)):
        with contextlib.suppress(InputError):
            assert np.isfinite(inverse.solve(J, wish)).all()
    if isinstance(inverse, rik.SingularValueFilter):
        assert np.isfinite(inverse.gains([size, size])).all()


def test_the_largest_gain_of_the_smallest_and_largest_arms_is_no_error():
    assert rik.MoorePenrose().largest_gain(1e-320) == np.inf
    for inverse in (rik.Chiaverini(), rik.ESRIM(), rik.ChiaveriniFiltering()):
        assert 0 < inverse.largest_gain(1e308) == inverse.largest_gain(1e3)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: rik.explain(J, XDOT, None), "inverse must be a RobustInverse, got None"),
        (lambda: rik.explain(J, XDOT, rik.JParse(), rows=7), "rows must be a sequence, each a str or None"),
        (lambda: rik.OutAndBack(np.eye(4), "x"), "goal must be an array of real numbers, got 'x'"),
        (lambda: rik.OutAndBack(np.eye(4), np.zeros(3), travel="x"), "travel must be > 0, got 'x'"),
        (lambda: rik.OutAndBack(np.eye(4), np.zeros(3))("soon"), "time must be one finite number, got 'soon'"),
        (lambda: rik.PositionTask(np.full(3, 1e308)), "target must lie within ±1e.100"),
        (lambda: rik.FrameTask(np.eye(4) * 1e308), "target must lie within ±1e.100"),
        (lambda: rik.find_singularities("panda"), "robot must be a Robot, got 'panda'"),
        (lambda: rik.JParse().largest_gain("x"), "sigma_max must be a number, got 'x'"),
        (lambda: rik.JParse().gains([1.0, -1.0]), "s must be singular values, finite and not negative"),
        (lambda: rik.JParse().gains([]), "at least one singular value"),
        (lambda: rik.Stepper(None), "robot must be a Robot, got None"),
        (lambda: rik.load("panda").pose(np.zeros(7), frame=[]), "a frame is named by a str"),
        (lambda: rik.load("panda", xacro_args=np.ones(2)), "xacro_args must map names to values"),
        (lambda: rik.CollisionLimit.of(rik.load("ur5"), obstacles=np.array(1.0)), "obstacles must be Obstacle"),
        (lambda: rik.CollisionLimit.of(rik.load("ur5"), pairs=np.array(1.0)), "pairs must be pairs of names"),
        (lambda: rik.compare(range(3)), "scenarios must be a Scenario or a sequence, each a Scenario"),
        (lambda: rik.newton("x", "x", rik.JParse(), [0.0], [1.0]), "kinematics must be a function, got 'x'"),
        (lambda: newton(jacobian=lambda q: np.eye(2)[None]), "jacobian.q. must be one matrix, got an array of shape"),
        (lambda: newton(hessian=lambda q: "x"), "hessian.q. must be an array of real numbers, got 'x'"),
        (lambda: newton(integrate=lambda q, dq: None), "integrate.q, dq. must be an array of real numbers"),
        (lambda: rik.MoorePenrose().jumps(()), r"sigma_max must be a number, got \(\)"),
        (lambda: rik.EDLS().gain_at_zero(range(3)), "sigma_max must be a number"),
        (lambda: rik.ESRIM().largest_gain(np.ones((2, 2))), "sigma_max must be a number"),
        (lambda: rik.Circle(np.eye(4), [0.1, 0, 0], [[0, 0, 1]]), "normal must be one vector, got an array of shape"),
        (lambda: rik.Line(np.eye(4)[None], [0.1, 0, 0]), "start must be one matrix, got an array of shape"),
        (lambda: rik.JointLimits.of("panda"), "robot must be a Robot, got 'panda'"),
        (lambda: rik.JointLimits.of(rik.load("panda"), margin=np.full(7, 1j)), "margin must be one number or 7, one"),
        (lambda: rik.load("panda").random(np.random.default_rng(0), False), "size must be a count"),
        (lambda: rik.TaskReconstruction(bound=None), "bound must be a number or a sequence, each a number, got None"),
        (lambda: rik.Scenario("a", rik.load("planar_2r"), [0, 0], POSTURE, 1.0, limits=np.nan), "limits must be"),
        (lambda: largest_stable_dt(rik.JParse(), [], 1.0), "gain must be one number > 0"),
        (lambda: rik.explain(J, XDOT, rik.JParse(), qdot=np.full(6, 1e308)), "qdot must lie within"),
        (lambda: rik.VelocityController(rik.load("panda")).step(np.full(7, 1e308), rik.DampingTask(), 0.01), "q must"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_said_to_be(call, words):
    with pytest.raises(InputError, match=words):
        call()


@pytest.mark.parametrize("limits", [None, ()])
def test_a_target_beyond_all_numbers_is_refused_with_limits_and_without(limits):
    robot = rik.load("planar_2r")
    far = np.eye(4)
    far[0, 3] = 1e308
    with pytest.raises(InputError, match="target must lie within"):
        rik.VelocityController(robot, rik.JParse(), limits).step(robot.rest, [[rik.FrameTask(far)]], 0.01)
    far[0, 3] = 1e99
    result = rik.VelocityController(robot, rik.JParse(), limits).step(robot.rest, [[rik.FrameTask(far)]], 0.01)
    assert np.isfinite(result.qdot).all()


def test_annotations_are_what_is_checked():
    @checked
    def function(a: "float", b: "Sequence[str] | None" = None, c: "Unknown" = None, *, d: "Mapping[str, int]" = {}):  # noqa: B006, F821
        return a

    assert function(1, ["x"], object(), d={"x": 1}) == 1
    assert function(np.float32(2.0)) == 2
    for given in ({"a": "x"}, {"a": 1, "b": "x"}, {"a": 1, "b": [1]}, {"a": 1, "d": {"x": 1.5}}, {"a": 1, "d": 3}):
        with pytest.raises(InputError, match="must be"):
            function(**given)
    with pytest.raises(TypeError, match="unexpected keyword"):
        function(1, e=2)
    check_type("n", np.int64(3), "int")
    with pytest.raises(InputError, match="n must be a whole number or None, got True"):
        check_type("n", True, "int | None")


def test_what_overflows_is_told():
    @computed
    def product(x: "ArrayLike"):  # noqa: F821
        return np.asarray(x) * np.asarray(x) - np.asarray(x) * np.asarray(x)

    assert product([1.0])[0] == 0
    with pytest.raises(InputError, match="product overflows for what was given: .1e.308"):
        product([1e308])
