"""The command, as its user sees it."""

import json
import re
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from rich.console import Console

import robust_ik as rik
from robust_ik import cli
from robust_ik.cli import terminal_tables
from robust_ik.description.catalog import catalog
from robust_ik.inverses import CLASSES
from robust_ik.simulation.scenarios import stretch


def run(capsys, *arguments, monkeypatch=None):
    """Exit status, standard output and standard error of the command."""
    monkeypatch.setattr(sys, "argv", ["robust-ik", *arguments])
    monkeypatch.setattr(cli.console, "width", 200)
    monkeypatch.setattr(cli.errors, "width", 200)
    with pytest.raises(SystemExit) as stop:
        cli.main()
    captured = capsys.readouterr()
    return stop.value.code, captured.out, captured.err


@pytest.fixture
def command(capsys, monkeypatch, tmp_path, request):
    monkeypatch.chdir(tmp_path)
    if request.node.originalname.startswith("test_what_cannot"):
        (tmp_path / "file").write_text("a file")
    return lambda *arguments: run(capsys, *arguments, monkeypatch=monkeypatch)


@pytest.mark.slow
def test_demo_prints_a_row_per_method_and_writes_one_file(command, tmp_path):
    status, out, _ = command("demo", "planar_2r")
    assert status == 0
    for method in ("MoorePenrose", "DampedLeastSquares", "JParse"):
        assert re.search(rf"^ +{method} +\d", out, re.MULTILINE)
    assert "[mm]" in out
    assert "[deg]" in out
    for word in ("Largest joint speed", "final tracking error", "smallest singular value", "time of a control step"):
        assert word in " ".join(out.split())
    written = list(tmp_path.iterdir())
    assert [path.name for path in written] == ["robust-ik-demo-planar_2r.html"]
    assert str(written[0]) in out


def test_demo_takes_methods_a_path_and_an_output(command, tmp_path):
    path = tmp_path / "new" / "page.html"
    urdf = str(catalog()["ur5"].path)
    status, out, _ = command("demo", urdf, "--tip", "ee_link", "--method", "jparse", "-o", str(path))
    assert status == 0
    assert "JParse" in out
    assert "MoorePenrose" not in out
    assert path.stat().st_size > 100_000


def test_demo_says_which_rows_a_short_arm_follows(command):
    status, out, _ = command("demo", "so100", "--method", "JParse")
    assert status == 0
    assert "5 joints cannot move it in all of x y z wx wy wz: it follows x y z" in out


def test_robots_lists_ours_and_the_examples(command):
    status, out, _ = command("robots")
    assert status == 0
    for name in catalog():
        assert f" {name} " in out
    assert re.search(r"panda +7 +panda_hand_tcp", out)
    assert re.search(r"duleba_3r +3 +tool", out)
    assert re.search(r"baxter +\d+ +29 leaves: give --tip", out)


def test_info_says_what_a_person_checks_first(command):
    status, out, _ = command("info", "panda")
    assert status == 0
    for text in ("panda_joint4", "-3.072", "revolute", "panda_hand_tcp", "manipulability", "reach", "σ at rest"):
        assert text in out
    s = np.linalg.svd(rik.load("panda").jacobian(rik.load("panda").rest))[1]
    assert f"{s[0]:.3g}" in out


def test_info_says_that_a_rest_is_singular_and_that_meshes_are_missing(command, tmp_path):
    link, stretched = "{ a = 1, d = 0, alpha = 0 }", tmp_path / "stretched.toml"
    stretched.write_text(
        f'convention = "standard"\nangles = "deg"\nrows = ["x", "y"]\nrest = [0, 0]\njoint = [{link}, {link}]'
    )
    assert "infinite: the rest is singular" in command("info", str(stretched))[1]
    out = command("info", "romeo_laas_small", "--tip", "l_gripper")[1]
    assert "is none of .stl" in out


def test_export_writes_a_urdf_that_loads_as_the_same_robot(command, tmp_path, rng):
    path = tmp_path / "pa10.urdf"
    assert command("export", "pa10", str(path))[0] == 0
    robot, again = rik.load("pa10"), rik.load(path)
    q = robot.random(rng, 5)
    np.testing.assert_allclose(again.pose(q), robot.pose(q), atol=1e-12)
    assert list(tmp_path.iterdir()) == [path]


def test_export_does_not_overwrite_unless_forced(command, tmp_path):
    path = tmp_path / "x.urdf"
    path.write_text("precious")
    status, _, err = command("export", "pa10", str(path))
    assert status == 1
    assert "--force" in err
    assert path.read_text() == "precious"
    assert command("export", "pa10", str(path), "--force")[0] == 0


@pytest.mark.parametrize(
    "arguments, match",
    [
        (["demo", "nobody"], "no robot called 'nobody'"),
        (["demo", "baxter"], "give a tip"),
        (["info", "hector"], "no joint that moves"),
        (["demo", "panda", "--tip", "toool"], "no link or joint 'toool'"),
        (["demo", "panda", "--method", "magic"], "no method 'magic'"),
        (["info", "missing.urdf"], "no file"),
        (["export", "pa10", "file/x.urdf"], "no folder, so that"),
        (["demo", "planar_2r", "--method", "JParse", "-o", "."], "folder|directory"),
        (["singularities", "planar_2r", "--markdown", "--latex"], "choose one of"),
        (["singularities", "planar_2r", "--json", "x", "--html", "x"], "cannot both be written to 'x'"),
        (["certify", "planar_2r", "--time-limit", "nan"], "time_limit must be"),
        (["certify", "planar_2r", "--time-limit", "inf"], "time_limit must be"),
    ],
)
def test_what_cannot_be_done_is_one_sentence_on_stderr_and_status_one(command, arguments, match):
    status, out, err = command(*arguments)
    assert status == 1
    assert re.search(match, err)
    assert err.startswith("robust-ik: ")
    assert "Traceback" not in out + err
    assert len(err.strip().splitlines()) == 1


def test_names_from_files_are_printed_as_they_are(command, tmp_path):
    path = tmp_path / "markup.urdf"
    path.write_text(
        '<robot name="[red]x[/]"><link name="[b]a"/><link name="c"/><joint name="[/]j" type="continuous">'
        '<parent link="[b]a"/><child link="c"/><axis xyz="0 0 1"/></joint></robot>'
    )
    status, out, _ = command("info", str(path))
    assert status == 0
    assert "[red]x[/]" in out
    assert "[/]j" in out
    status, out, _ = command("singularities", str(path), "--starts", "5")
    assert status == 0
    assert "[red]x[/]" in out


def test_help_and_version_answer(command):
    status, out, _ = command("--help")
    assert status == 0
    assert all(name in out for name in ("demo", "robots", "info", "export"))
    assert rik.__version__ in command("--version")[1]


def test_the_module_is_installed_as_a_command():
    path = sys.executable.rsplit("/", 1)[0] + "/robust-ik"
    done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == f"robust-ik {rik.__version__}"


def test_the_comparison_holds_the_numbers_of_the_runs():
    scenario = stretch(rik.load("planar_2r"))
    run = scenario.run(rik.JParse())
    console = Console(width=200, record=True, file=open("/dev/null", "w"))  # noqa: SIM115, PTH123
    console.print(terminal_tables.comparison({"JParse": run}))
    console.file.close()
    text = console.export_text()
    assert f"{run.largest_speed:.3g}" in text
    assert f"{1e3 * run.position_error.max():.1f}" in text


def test_inverses_lists_every_inverse_with_its_promises(command):
    status, out, _ = command("inverses")
    assert status == 0
    for each in CLASSES:
        assert each.__name__ in out
    assert "largest gain" in out
    chosen = command("inverses", "edls", "JPARSE")[1]
    assert "EDLS" in chosen
    assert "gamma" in chosen
    assert "Halley" not in chosen


def test_inverses_prints_the_table_of_the_readme_and_draws_the_gains(command, tmp_path):
    assert command("inverses", "--markdown")[1].strip() == terminal_tables.inverses_markdown(CLASSES)
    status, out, _ = command("inverses", "JParse", "EDLS", "--plot", "gains.png")
    assert status == 0
    assert "gains.png" in out
    assert (tmp_path / "gains.png").read_bytes().startswith(b"\x89PNG")
    assert command("inverses", "SDLS", "--plot", "gains.svg")[0] == 1


@pytest.mark.slow
def test_any_inverse_can_drive_the_demo(command, monkeypatch):
    monkeypatch.setattr("robust_ik.simulation.scenarios.stretch", partial(stretch, travel=0.3, pause=0.1, settle=0.1))
    for each in CLASSES:
        if each is not rik.Weighted:
            status, out, _ = command("demo", "planar_2r", "--method", each.__name__, "-o", "page.html")
            assert status == 0
            assert each.__name__ in out


# ------------------------------------------------------------------------------------------------ singularities
def test_singularities_prints_the_atlas_and_writes_what_is_asked_for(command, tmp_path):
    status, out, _ = command("singularities", "planar_3r", "--starts", "50", "--json", "a.json", "--html", "a.html")
    assert status == 0
    assert "q2 ∈ {0, π} and q3 ∈ {0, π}" in out
    assert "certified: there are no others" in out
    assert rik.SingularityAtlas.load(tmp_path / "a.json").settings.starts == 50
    assert (tmp_path / "a.html").read_text().count("</html>") == 1


def test_singularities_can_be_printed_for_papers_and_without_proofs(command):
    status, out, _ = command("singularities", "planar_2r", "--starts", "50", "--latex", "--no-certify")
    assert status == 0
    assert out.startswith(r"\begin{tabular}")
    options = ("planar_2r", "--starts", "50", "--markdown", "--corank", "1", "--no-certify")
    _, out, _ = command("singularities", *options)
    assert "| 1 | q2 ∈ {0, π} |" in out
    assert "probability below" in out
    assert command("singularities", *options, "--workers", "2")[1] == out


def test_certify_proves_every_corank_and_verify_checks_them_in_any_file(command, tmp_path):
    status, out, _ = command("certify", "duleba_3r", "-o", "proofs.json")
    assert status == 0
    assert [f"corank {k}: certified" in out for k in (1, 2, 3)] == [True] * 3
    status, out, _ = command("verify", "proofs.json")
    assert status == 0
    assert out.count("accepted") == 3
    command("certify", "duleba_3r", "--corank", "1", "-o", "one.json")
    assert command("verify", "one.json")[1].count("accepted") == 1
    command("singularities", "duleba_3r", "--starts", "50", "--json", "atlas.json")
    assert command("verify", "atlas.json")[1].count("accepted") == 3
    data = json.loads((tmp_path / "proofs.json").read_text())
    next(node for node in data["proofs"][0]["nodes"] if node["kind"] == "leaf")["kind"] = "contradiction"
    (tmp_path / "broken.json").write_text(json.dumps(data))
    status, out, _ = command("verify", "broken.json")
    assert status == 1
    assert "corank 1: not accepted" in out
    assert "corank 2: accepted" in out


@pytest.mark.parametrize("content, message", [("no json", "no JSON"), ("{}", "not a"), ("[]", "must be an object")])
def test_what_is_no_certificate_is_refused_in_a_sentence(command, tmp_path, content, message):
    (tmp_path / "bad.json").write_text(content)
    status, _, err = command("verify", "bad.json")
    assert status == 1
    assert message in err


def test_an_atlas_without_proofs_has_nothing_to_verify(command):
    command("singularities", "planar_2r", "--starts", "50", "--json", "atlas.json", "--no-certify")
    status, _, err = command("verify", "atlas.json")
    assert status == 1
    assert "holds no proof" in err


# ------------------------------------------------------------------------------------------------ compare
SCENARIO = """
title = "a short line"
source = "ours"
[robot]
name = "planar_2r"
[start]
joints = [0.3, 0.9]
[target]
kind = "line"
to = [1.0, 0.0, 0.4]
speed = 0.5
[control]
gain = 5.0
[methods]
"calm [a]" = { type = "JParse", gamma = 0.2 }
"""


@pytest.mark.slow
def test_compare_lists_what_there_is_and_runs_a_file_with_its_methods_or_others(command, tmp_path):
    status, out, _ = command("compare")
    assert status == 0
    assert "xarm7_line" in out
    (tmp_path / "mine.toml").write_text(SCENARIO)
    status, out, _ = command("compare", "mine.toml", "--html", "runs.html", "--plot", "runs.png")
    assert status == 0
    assert "a short line" in out
    assert re.search(r"calm \[a\] +\d", out)
    assert (tmp_path / "runs.html").stat().st_size > 100_000
    assert (tmp_path / "runs.png").read_bytes().startswith(b"\x89PNG")
    _, out, _ = command("compare", "mine.toml", "--methods", "sdls", "--methods", "calm [a]", "--workers", "2")
    assert re.search(r"sdls +\d", out)
    assert re.search(r"calm \[a\] +\d", out)
    _, out, _ = command("compare", "mine.toml", "--methods", "TaskReconstruction", "--methods", "weightedpriority")
    assert re.search(r"TaskReconstruction +\d", out)
    assert re.search(r"weightedpriority +\d", out)
    status, out, _ = command("compare", "mine.toml", "--reach")
    assert status == 0
    assert re.search(r"calm \[a\] +\d", out)


@pytest.mark.parametrize(
    "arguments, message",
    [
        (("nothing",), "no scenario 'nothing'"),
        (("missing.toml",), "no file 'missing.toml'"),
        (("xarm7_line", "--methods", "magic"), "no method 'magic'"),
        (("xarm7_line", "--plot", "figure.txt"), "one of .png, .svg, .pdf"),
        (("xarm7_line", "--html", "."), "is a folder"),
        (("xarm7_line", "--workers", "0"), "workers must be a whole number of at least 1, got 0"),
    ],
)
def test_what_cannot_be_compared_is_told_before_anything_runs(command, monkeypatch, arguments, message):
    monkeypatch.setattr("robust_ik.simulation.comparison.compare", lambda *given, **options: pytest.fail("it ran"))
    status, _, err = command("compare", *arguments)
    assert status == 1
    assert message in err


# ------------------------------------------------------------------------------------------------ results
RESULTS = [
    ("demo", "planar_2r", "-o"),
    ("compare", "xarm7_line", "--html"),
    ("compare", "xarm7_line", "--plot"),
    ("singularities", "planar_2r", "--json"),
    ("singularities", "planar_2r", "--html"),
    ("certify", "planar_2r", "-o"),
    ("inverses", "--plot"),
    ("export", "planar_2r"),
]


@pytest.mark.parametrize("arguments", RESULTS, ids=" ".join)
def test_where_nothing_can_be_written_is_told_before_the_work(command, monkeypatch, arguments):
    for work in (
        "robust_ik.robot.loading.load",
        "robust_ik.simulation.scenarios.load_scenario",
        "robust_ik.display.plot_gains",
    ):
        monkeypatch.setattr(work, lambda *_, **__: pytest.fail("it ran"))
    for place, words in (("no/such/x.png", "there is no folder"), ("/proc/x.png", "nothing can be written in")):
        status, _, err = command(*arguments, place)
        assert status == 1
        assert words in err


def test_a_result_on_standard_output_can_be_read_by_a_program(command):
    status, out, err = command("singularities", "planar_2r", "--starts", "5", "--json", "-")
    assert status == 0
    assert json.loads(out)["format"] == "robust_ik singularity atlas"
    assert "q2 ∈ {0, π}" in err
    assert "Wrote -" in err
    assert command("export", "planar_2r", "/dev/fd/1")[1].startswith("<robot")
    assert command("robots")[1]


def test_a_folder_that_is_made_is_told(command, tmp_path):
    _, _, err = command("export", "planar_2r", "out/x.urdf")
    assert err == f"There is no folder {tmp_path / 'out'} yet: it is made.\n"
    assert (tmp_path / "out" / "x.urdf").exists()


@pytest.mark.parametrize("name", ["info", "demo", "singularities", "certify"])
def test_a_folder_of_packages_that_is_not_there_is_refused(command, name):
    status, _, err = command(name, "planar_2r", "--package-dir", "/nope")
    assert status == 1
    assert "--package-dir: there is no folder '/nope'" in err
    for given in (["/nope"], "/nope", [None], 7):
        with pytest.raises(rik.InputError, match="package_dirs"):
            rik.load("ur5", package_dirs=given)
