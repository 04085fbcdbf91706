"""Names from files, in every medium: they are shown, and do nothing."""

import json
import re
import sys
import tomllib
from collections import Counter
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from rich.console import Console
from rich.text import Text

import robust_ik as rik
from robust_ik import cli
from robust_ik.display import write_html
from robust_ik.errors import LONGEST_MESSAGE, InputError
from robust_ik.errors.safe_text import (
    in_figure,
    in_html,
    in_latex,
    in_markdown,
    in_markup,
    plain,
    visible,
    visible_lines,
)

NASTY = [
    "<script>alert(1)</script>",
    "</script><img src=x onerror=alert(1)>",
    "<!--",
    "]]>\"' onload='x",
    "[link](javascript:alert(1)) ![i](http://example.org/x)",
    "a | b | `c` **d** _e_ ~~f~~ $g$ \\",
    "[red]x[/] [/] :warning: \\[b]",
    "\\input{/etc/passwd} ^^5cinput $x^2_3$ 100% #1 &~",
    "abc\u202edcba\u2066\u200b\ufeff\u00ad\U000e0041",
    "\x80\x9b31m\x7f\u2028\u2029\u0085",
    "_hidden",
    "$ {body} $data %s {0} {{x}}",
    "конец 手 😀 é",
]
"""What XML can hold; the last is harmless, and stays as it is."""
CONTROL = ["\x1b[31mred\x1b]0;title\x07", "a\rb\nc\td\x00e\x08", "half \ud800 letter"]
"""What only other files can."""

texts = st.text(max_size=30)


def seen(text):
    """Whether a terminal shows it as it is, line by line."""
    return all(letter.isprintable() or letter == "\n" for letter in text)


class Tags(HTMLParser):
    """What a page is made of."""

    def __init__(self, page):
        super().__init__()
        self.found, self.text, self.open = Counter(), [], True
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.found[tag, tuple(sorted(name for name, _ in attributes))] += 1

    def handle_comment(self, data):
        self.found["a comment", data] += 1

    def handle_data(self, data):
        self.text.append(data)


# ------------------------------------------------------------------------------------------------ each medium
@given(texts)
@example("".join(NASTY + CONTROL))
def test_visible_text_is_visible_and_stays_as_it_is(text):
    assert visible(text).isprintable()
    assert visible(visible(text)) == visible(text)
    assert seen(visible_lines(text))
    if text.isprintable():
        assert visible(text) == text


@given(texts)
@example("".join(NASTY + CONTROL))
def test_markup_of_rich_shows_the_text_and_nothing_else(text):
    assert Text.from_markup(f"[bold]{in_markup(text)}[/] end", emoji=False).plain == f"{visible(text)} end"
    assert plain(text).plain == visible_lines(text)
    assert not plain(text).spans


@given(texts)
@example("".join(NASTY + CONTROL))
def test_in_html_it_is_text_and_nothing_else(text):
    page = Tags(f'<b title="{in_html(text)}">{in_html(text)}</b>')
    assert page.found == {("b", ("title",)): 1}
    assert "".join(page.text) == visible_lines(text)
    in_html(text).encode()


@given(texts)
@example("".join(NASTY + CONTROL))
def test_in_markdown_it_is_text_and_nothing_else(text):
    reader = MarkdownIt("gfm-like", {"linkify": False})
    page = reader.render(f"| a |\n|---|\n| x {in_markdown(text)} x |\n")
    assert set(Tags(page).found) == {(tag, ()) for tag in ("table", "thead", "tbody", "tr", "th", "td")}
    shown = page.partition("<td>")[2].partition("</td>")[0]
    assert unescape(shown).split() == f"x {visible(text)} x".split()


@given(texts)
@example("".join(NASTY + CONTROL))
def test_in_latex_no_command_comes_of_it(text):
    plainly = in_latex(text)
    for own in (
        r"\ensuremath{\backslash}",
        r"\ensuremath{\sim}",
        r"\ensuremath{\wedge}",
        *(rf"\{x}" for x in "{}$&#_%"),
    ):
        plainly = plainly.replace(own, "")
    assert not set(plainly) & set("\\{}$&#_%~^")


@given(texts.filter(lambda text: "\n" not in text))
@example("".join(NASTY + CONTROL))
def test_in_a_figure_no_formula_comes_of_it(text):
    from matplotlib.cbook import is_math_text

    assert not is_math_text(in_figure(text))


def test_every_error_is_one_visible_line_that_is_cut():
    error = InputError("\u202e" * 10**6 + "\x1b[31m\n" + "z")
    assert str(error).isprintable()
    assert len(str(error)) <= LONGEST_MESSAGE
    assert str(error).endswith("z")


# ------------------------------------------------------------------------------------------------ the commands
def urdf(names):
    """An arm of two joints in a plane, with a mesh that is not there."""
    robot, base, first, second, tip, joint, other, mesh = (quoteattr(name) for name in names)
    return (
        f"<robot name={robot}><link name={base}/><link name={first}/>"
        f"<link name={second}><visual><geometry><mesh filename={mesh}/></geometry></visual></link><link name={tip}/>"
        f'<joint name={joint} type="continuous"><parent link={base}/><child link={first}/><axis xyz="0 1 0"/></joint>'
        f'<joint name={other} type="continuous"><parent link={first}/><child link={second}/><axis xyz="0 1 0"/>'
        f'<origin xyz="0.3 0 0"/></joint>'
        f'<joint name="fixed" type="fixed"><parent link={second}/><child link={tip}/><origin xyz="0.2 0 0"/></joint>'
        "</robot>"
    )


def names(words):
    """Eight of them, no two alike, the robot's without what a path cannot hold."""
    chosen = [f"{words[index % len(words)]}{index}" for index in range(8)]
    return [*chosen[:7], chosen[7] + ".stl"]


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Runs the command; whatever it prints can be seen."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments, status=0):
        monkeypatch.setattr(sys, "argv", ["robust-ik", *map(str, arguments)])
        for console in (cli.console, cli.errors):
            monkeypatch.setattr(console, "width", 500)
        with pytest.raises(SystemExit) as stop:
            cli.main()
        printed = capsys.readouterr()
        assert stop.value.code == status, printed.err
        assert seen(printed.out + printed.err)
        assert "Traceback" not in printed.err
        return printed.out + printed.err

    return run


@pytest.mark.parametrize("words", [NASTY[start::2] for start in range(2)], ids=str)
def test_a_robot_with_nasty_names_goes_through_every_command(command, tmp_path, words):
    given = names(words)
    (tmp_path / "nasty.urdf").write_text(urdf(given), encoding="utf-8")
    (tmp_path / "plain.urdf").write_text(urdf([f"name{index}" for index in range(7)] + ["x.stl"]), encoding="utf-8")
    out = command("info", "nasty.urdf")
    for name in given[:1] + given[4:7]:
        assert visible(name) in out
    assert visible(given[7]) in out
    assert visible(given[4]) in command("info", "nasty.urdf", "--tip", "nothing", status=1)
    pages = {}
    for name in ("nasty", "plain"):
        options = (f"{name}.urdf", "--starts", "5", "--no-certify")
        command("singularities", *options, "--json", f"{name}.json", "--html", f"{name}.html")
        command("demo", f"{name}.urdf", "--method", "JParse", "-o", f"{name}-demo.html")
        pages[name] = [Tags((tmp_path / page).read_text("utf-8")) for page in (f"{name}.html", f"{name}-demo.html")]
    for nasty, ordinary in zip(*pages.values()):
        assert nasty.found == ordinary.found
        assert any(visible(given[0]) in text for text in nasty.text)
    atlas = rik.SingularityAtlas.load(tmp_path / "nasty.json")
    assert atlas.robot.name == given[0]
    command("export", "nasty.urdf", "again.urdf")
    assert rik.load(tmp_path / "again.urdf").name == given[0]
    command("certify", "nasty.urdf", "-o", "proofs.json")
    command("verify", "proofs.json")


def test_an_atlas_s_file_cannot_bring_anything_into_tables_and_pages(tmp_path, command):
    (tmp_path / "plain.urdf").write_text(urdf([f"name{index}" for index in range(7)] + ["x.stl"]))
    command("singularities", "plain.urdf", "--starts", "5", "--no-certify", "--json", "a.json")
    data = json.loads((tmp_path / "a.json").read_text())
    for word in [*NASTY, *CONTROL]:
        data["robot"]["name"] = data["robot"]["tip"] = word
        data["robot"]["changes"] = [word]
        for row in data["strata"]:
            row["conditions"][0]["words"] = word
            row["equations"] = [word]
        (tmp_path / "b.json").write_text(json.dumps(data))
        atlas = rik.SingularityAtlas.load(tmp_path / "b.json")
        reader = MarkdownIt("gfm-like", {"linkify": False})
        tags = {tag for tag, _ in Tags(reader.render(atlas.markdown())).found}
        assert tags <= {"table", "thead", "tbody", "tr", "th", "td", "p"}
        assert seen(atlas.markdown())
        assert r"\input" not in atlas.latex()
        assert "^^" not in atlas.latex()
        with (tmp_path / "out").open("w", encoding="utf-8") as file:
            Console(width=500, emoji=False, file=file).print(atlas.table())
        assert seen((tmp_path / "out").read_text("utf-8"))
        atlas.save(tmp_path / "c.json")
        assert rik.SingularityAtlas.load(tmp_path / "c.json").robot.name == word


SCENARIO = """
title = {0}
source = {0}
note = {0}
[robot]
name = "planar_2r"
[start]
joints = [0.3, 0.9]
[target]
kind = "line"
to = [1.0, 0.0, 0.4]
speed = 2.0
[control]
gain = 5.0
[methods]
{0} = {{ type = "JParse", gamma = 0.2 }}
"""


def test_a_scenario_with_nasty_words_is_compared_and_drawn(command, tmp_path):
    pages = []
    for words in ("".join(NASTY + CONTROL[:2]), "plain"):
        text = SCENARIO.format(json.dumps(words, ensure_ascii=True).replace("\\u0000", "").replace("\\ude00", ""))
        text = text.replace("\\ud83d", "").replace("\\udb40\\udc41", "").replace("\\x7f", "")
        tomllib.loads(text)
        (tmp_path / "mine.toml").write_text(text)
        assert "[red]x[/] [/] :warning:" in command("compare", "mine.toml", "--html", "x.html", "--plot", "x.svg") or (
            words == "plain"
        )
        pages.append(Tags((tmp_path / "x.html").read_text("utf-8")))
    assert pages[0].found == pages[1].found


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1, max_size=12), min_size=1, max_size=8)
)
def test_any_names_go_through(command, tmp_path, words):
    (tmp_path / "any.urdf").write_text(urdf(names(words)), encoding="utf-8")
    command("info", "any.urdf")
    command("info", "any.urdf", "--tip", words[0] + "?", status=1)
    command("singularities", "any.urdf", "--starts", "5", "--no-certify", "--markdown")
    command("singularities", "any.urdf", "--starts", "5", "--no-certify", "--latex")


def test_labels_of_runs_are_text_in_a_page_also_those_that_are_hidden_in_figures(tmp_path):
    from robust_ik.display.figures.run_figures import runs_figure
    from robust_ik.simulation.scenarios import stretch

    run = stretch(rik.load("planar_2r")).run(rik.JParse())
    runs = dict.fromkeys([*NASTY, *CONTROL], run)
    page = Tags(write_html(tmp_path / "x.html", runs).read_text("utf-8"))
    assert page.found["script", ("id", "type")] <= 1
    assert not any(tag in ("img", "a comment") for tag, _ in page.found)
    shown = [text.get_text() for text in runs_figure(runs).legends[0].get_texts()]
    assert shown == [in_figure(name) for name in runs]


def test_nothing_but_this_module_escapes():
    root = Path(rik.__file__).parent
    allowed = {
        root / "errors" / "safe_text.py",
        root / "display" / "scene" / "scene.py",
        root / "display" / "scene" / "html_page.py",
    }
    for path in set(root.rglob("*.py")) - allowed:
        assert not re.search(r"html\.escape|rich\.markup|import html\b", path.read_text("utf-8")), path
