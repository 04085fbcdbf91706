import base64
import html
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
import umsgpack
from numpy.testing import assert_allclose

from robust_ik.control.tasks import Follow
from robust_ik.control.tasks.target_paths import OutAndBack
from robust_ik.display import Scene, draw_run, write_html
from robust_ik.display.drawings.run_frames import Frames
from robust_ik.display.pages.comparison_page import report_page
from robust_ik.display.pages.run_table import breakable, number
from robust_ik.display.pages.svg_chart import ChartCurve, Scale, chart
from robust_ik.display.scene.animation_tracks import LARGEST
from robust_ik.errors import InputError
from robust_ik.inverses import DampedLeastSquares, JParse, MoorePenrose
from robust_ik.robot.robot import Robot
from robust_ik.simulation.simulator import simulate

EVIL = '</script><script>alert(1)</script>"><img src=http://evil.example/x onerror=alert(1)>'
ARM = """<robot name={name}><link name="base"/><link name="upper">{visual}</link><link name="tool"/>
 <joint name="one" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/>
  <limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
 <joint name="two" type="{kind}"><parent link="upper"/><child link="tool"/><origin xyz="1 0 0"/>
  <axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
 <joint name="three" type="fixed"><parent link="tool"/><child link="tip"/><origin xyz="1 0 0"/></joint>
 <link name="tip"/>
</robot>"""
METHODS = (MoorePenrose(), JParse(), DampedLeastSquares())


def robot(tmp_path, name="arm", visual="", kind="revolute", axis="0 -1 0", rows=("x", "z")):
    path = tmp_path / "arm.urdf"
    quoted = '"' + html.escape(name) + '"'
    path.write_text(ARM.format(name=quoted, visual=visual, kind=kind, axis=axis), encoding="utf-8")
    return Robot.from_urdf(path, tip="tip", rows=rows)


def run_of(arm, inverse=None, duration=0.8, dt=0.02):
    q0 = np.array([0.3, 1.2])
    path = OutAndBack(arm.pose(q0), [2.1, 0, 0.4], travel=0.3, pause=0.1)
    return simulate(arm, inverse or JParse(), Follow(path, gain=10), q0, duration=duration, dt=dt, limits=())


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    return robot(tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def runs(arm):
    return {type(method).__name__: run_of(arm, method) for method in METHODS}


@pytest.fixture(scope="module")
def page(runs):
    return report_page(runs, title="A title", text="A text")


class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.found, self.texts = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.lasttag not in ("script", "style"):
            self.texts.append(data)

    def of(self, tag):
        return [attributes for name, attributes in self.found if name == tag]


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])


def animations(page):
    return animations_of(data_of(page)["runs"])


def animations_of(motions):
    return [umsgpack.unpackb(base64.b64decode(motion["animation"])) for motion in motions]


def tracks(animation):
    """(path, name) → times (N,) and values (N, k)."""
    found = {}
    for clip in animation["animations"]:
        for track in clip["clip"]["tracks"]:
            times = np.frombuffer(track["times"].data, np.float32)
            values = track["values"]
            values = np.array(values) if isinstance(values, list) else np.frombuffer(values.data, np.float32)
            found[clip["path"], track["name"]] = times, values.reshape(len(times), -1)
    return found


# ---------------------------------------------------------------------------------------- the page
def test_the_page_needs_nothing_from_the_net(page):
    tags = Tags(page)
    for tag, attributes in tags.found:
        for name in ("src", "srcset", "data", "action", "poster", "xlink:href"):
            assert name not in attributes, (tag, name)
        assert not re.match(r"\s*(\w+:)?//", attributes.get("href", "")), tag
        assert not any(name.startswith("on") for name in attributes), tag
        assert "url(" not in attributes.get("style", "")
    assert not {"img", "iframe", "object", "embed", "base", "form", "a"} & {tag for tag, _ in tags.found}
    style = page.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style


def test_jparse_is_shown_first_and_every_run_has_a_button(page):
    names = [run["name"] for run in data_of(page)["runs"]]
    assert names == ["JParse", "MoorePenrose", "DampedLeastSquares"]
    buttons = [attributes["data-run"] for attributes in Tags(page).of("button") if "data-run" in attributes]
    assert buttons == ["0", "1", "2"]


def test_runs_may_come_as_a_sequence_and_bear_the_same_name(arm):
    names = [
        run["name"] for run in data_of(report_page([run_of(arm), run_of(arm, MoorePenrose()), run_of(arm)]))["runs"]
    ]
    assert names == ["JParse", "JParse (2)", "MoorePenrose"]


def test_the_robot_is_in_the_page_once_however_many_runs_there_are(runs):
    one, all_of_them = report_page({"a": runs["JParse"]}), report_page(runs)
    objects = [
        sum(umsgpack.unpackb(base64.b64decode(c))["type"] == "set_object" for c in data_of(p)["scene"])
        for p in (one, all_of_them)
    ]
    assert objects[1] == objects[0] + 2  # the trails


def test_the_page_says_what_came_out(page, runs):
    text = " ".join(Tags(page).texts)
    assert "A title" in text
    assert "A text" in text
    for run in runs.values():
        assert number(run.largest_speed) in text
        assert number(1e3 * run.position_error.max()) in text
        assert number(run.smallest_sigma) in text
    assert "Largest error [°]" not in text  # the task has no rows of rotation


# ---------------------------------------------------------------------------------------- animations
def test_every_animation_loops_over_the_same_time_and_is_finite(page, runs):
    for animation in animations(page):
        assert animation["options"] == {"play": True, "repetitions": float("inf")}
        assert_allclose([clip["clip"]["duration"] for clip in animation["animations"]], 0.78, rtol=1e-6)
        for (_, name), (times, values) in tracks(animation).items():
            assert np.isfinite(values).all()
            assert (np.diff(times) > 0).all()
            assert values.shape[1] == {".position": 3, ".quaternion": 4, ".scale": 3, ".visible": 1}[name]


def test_every_animation_moves_the_same_nodes(page):
    nodes = [set(tracks(animation)) for animation in animations(page)]
    ends = [{path for path, name in keys if name == ".position"} for keys in nodes]
    shown = [{path for path, name in keys if name == ".visible"} for keys in nodes]
    assert shown[0] == shown[1] == shown[2]
    assert {path for path in ends[0] if "/robot/" in path} == {path for path in ends[1] if "/robot/" in path}


def test_the_tip_follows_the_run(page, runs, arm):
    (path,) = {path for path, _ in tracks(animations(page)[0]) if path.endswith("_tip")}
    times, points = tracks(animations(page)[0])[path, ".position"]
    run = runs["JParse"]
    assert_allclose(points[[0, -1]], run.pose[[0, -1], :3, 3], atol=1e-6)
    assert times[-1] == pytest.approx(run.time[-1])


def test_what_the_joints_do_not_move_is_not_animated(page):
    assert not any("_base" in path for path, _ in tracks(animations(page)[0]))


def test_a_run_that_explodes_still_plays(tmp_path):
    slider = robot(tmp_path, kind="prismatic", axis="1 0 0")
    run = run_of(slider, MoorePenrose())
    q = np.array(run.q)
    q[3:] *= np.geomspace(1, 1e200, len(q) - 3)[:, None]
    wild = replace(run, q=q, pose=slider.pose(q), qdot=1e150 * run.qdot, error=1e100 * run.error)
    for made in (report_page({"calm": run_of(slider), "wild": wild}), report_page([wild])):
        check_that_it_plays(made)


def check_that_it_plays(made):
    commands = [umsgpack.unpackb(base64.b64decode(c)) for c in data_of(made)["scene"]]
    view = next(c["value"] for c in commands if c.get("property") == "view")
    assert max(np.abs(view)) < 100
    for values in (values for animation in animations(made) for _, values in tracks(animation).values()):
        assert np.isfinite(values).all()
        assert np.abs(values).max() <= LARGEST
    assert "nan" not in made.split('id="data"')[0].split("<main>")[1].lower()


def test_a_run_of_one_step_can_be_shown(arm):
    run = run_of(arm, duration=0.02)
    assert len(Frames.of(run).rows) == 2
    assert report_page([run])


@pytest.mark.parametrize(("dt", "frames"), [(0.001, 24), (0.02, 24), (0.2, 4)])
def test_runs_are_shown_at_about_thirty_frames_a_second(arm, dt, frames):
    run = run_of(arm, duration=0.8, dt=dt)
    shown = Frames.of(run)
    assert len(shown.rows) == pytest.approx(frames, abs=1)
    assert shown.rows[-1] == len(run.time) - 1


@pytest.mark.parametrize("rows", [("x",), ("wy",), ("z", "wy"), ("x", "y", "z", "wx", "wy", "wz")])
def test_any_task_rows_can_be_shown(tmp_path, rows):
    made = report_page([run_of(robot(tmp_path, rows=rows))])
    assert ('data-group="ellipsoid"' in made) == bool({"x", "y", "z"} & set(rows))


def test_a_live_scene_plays_a_run_and_then_another(arm):
    scene = Scene()
    for _ in range(2):
        draw_run(scene, run_of(arm))
    kinds = [umsgpack.unpackb(command)["type"] for command in scene.commands]
    assert kinds.count("set_animation") == 1


# ---------------------------------------------------------------------------------------- names from files
def test_no_name_can_bring_markup_into_the_page(tmp_path):
    visual = f'<visual><geometry><mesh filename="{html.escape(EVIL)}.stl"/></geometry></visual>'
    evil = robot(tmp_path, name=EVIL, visual=visual)
    for title in ("", EVIL):
        made = report_page({EVIL: run_of(evil), "b": run_of(evil, MoorePenrose())}, title=title, text=EVIL)
        tags = Tags(made)
        assert not tags.of("img")
        assert len(tags.of("script")) == 3
        assert made.count("</script>") == 3
        assert EVIL in html.unescape("".join(tags.texts))
        assert data_of(made)["runs"][0]["name"] == EVIL


def test_missing_meshes_are_named(tmp_path):
    visual = '<visual><geometry><mesh filename="gone &amp; lost.stl"/></geometry></visual>'
    text = "".join(Tags(report_page([run_of(robot(tmp_path, visual=visual))])).texts)
    assert "One mesh is not drawn" in text
    assert "gone & lost.stl" in text


# ---------------------------------------------------------------------------------------- writing
def test_the_page_is_written_where_it_should_be(tmp_path, runs):
    path = tmp_path / "a" / "b.html"
    assert write_html(path, runs, title="T") == path
    assert path.read_text(encoding="utf-8") == report_page(runs, title="T")
    assert [file.name for file in path.parent.iterdir()] == ["b.html"]
    assert path.stat().st_size < 3_000_000


@pytest.mark.parametrize("nothing", [{}, []])
def test_no_run_is_refused(nothing, tmp_path):
    with pytest.raises(InputError, match="no run"):
        write_html(tmp_path / "a.html", nothing)


def test_runs_of_different_robots_are_refused(arm, tmp_path):
    other = robot(tmp_path, name="other")
    with pytest.raises(InputError, match="one robot"):
        write_html(tmp_path / "a.html", [run_of(arm), run_of(other)])


def test_a_folder_is_refused(runs, tmp_path):
    with pytest.raises(InputError, match="is a folder"):
        write_html(tmp_path, runs)


# ---------------------------------------------------------------------------------------- numbers
def test_a_peak_of_one_step_stays_in_the_chart():
    values = np.ones(100_000)
    values[54_321] = 1000
    time, envelope = ChartCurve(np.arange(100_000.0), values, "#000").envelope()
    assert len(time) <= 240
    assert envelope.max() == 1000


def test_a_run_that_explodes_does_not_hide_the_others_in_the_chart():
    scale = Scale.for_values(np.concatenate([np.full(100, 0.5), np.geomspace(1, 1e12, 50)]), logarithmic=True)
    assert scale.low <= 0.1
    assert scale.high == 1e12
    assert len(scale.ticks) <= 6


@pytest.mark.parametrize("logarithmic", [True, False])
@pytest.mark.parametrize("values", [[0, 0, 0], [1e-300, 1e300], [0.5], [3, 3], [1e-9, 2e-9], [1.0, 0.0]])
def test_every_value_has_a_place_in_the_chart(values, logarithmic):
    values = np.array(values, float)
    scale = Scale.for_values(values, logarithmic)
    heights = scale.height(values)
    assert np.isfinite(heights).all()
    assert (heights >= 20).all()
    assert (heights <= 112).all()
    drawn = chart(
        "a < b", [ChartCurve(np.arange(len(values), dtype=float), values, "#123456")], 5.0, logarithmic=logarithmic
    )
    assert "a &lt; b" in drawn
    assert "nan" not in drawn
    assert "inf" not in drawn


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (1e-12, "0"), (4.2e-4, "4.2e-04"), (0.12345, "0.123"), (12.3456, "12.3"), (1234.5, "1,234"),
     (2.5e7, "2.5e+07"), (float("inf"), "not finite"), (float("nan"), "not finite")],
)  # fmt: skip
def test_numbers_have_three_digits(value, text):
    assert number(value) == text


def test_long_names_may_break_between_words():
    assert breakable("DampedLeast<b>") == "Damped<wbr>Least&lt;b&gt;"
