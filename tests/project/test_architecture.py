"""The architecture page, the contracts that hold it, and what every module owes its readers."""

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "robust_ik"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
MOST = 16
"""Files of a folder."""
PLUG_INS = {"inverses", "control/tasks"}
"""Folders of which each file is one of a kind: they may have more."""


def folders(below):
    return {path.parent.name for path in below.glob("*/__init__.py")}


def test_the_page_names_every_room_and_every_folder_in_it_and_no_other():
    rows = re.findall(r"^\| `(\w+)` \| [^|]+ \|([^|]*)\|$", PAGE, re.MULTILINE)
    assert {room for room, _ in rows} == folders(PACKAGE)
    for room, inside in rows:
        assert set(re.findall(r"`(\w+)`", inside)) == folders(PACKAGE / room), room


def test_rooms_stand_in_the_order_of_the_contract():
    contract = re.search(r"layers = \[\n(.*?)\]", (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.DOTALL)
    layers = [row.split(" | ") for row in re.findall(r'"([^"]+)"', contract[1])]
    assert len(layers) <= 11
    height = {room: -place for place, row in enumerate(layers) for room in row}
    shown = re.findall(r"^\| `(\w+)` \| [^|]+ \|[^|]*\|$", PAGE, re.MULTILINE)
    heights = [height[room] for room in shown]
    assert heights == sorted(heights)


@pytest.mark.parametrize("text", [PAGE, CONTRIBUTING], ids=["architecture", "contributing"])
def test_files_that_pages_name_are_there(text):
    named = re.findall(r"`((?:[a-z_]+/)+(?:[a-z_]+\.\w+)?)`", text)
    assert len(named) > 10
    for name in named:
        places = (ROOT / name, PACKAGE / name)
        assert any(place.exists() for place in places) or "my_" in name, name


def test_no_folder_has_more_files_than_one_can_read_as_a_list():
    for init in PACKAGE.rglob("__init__.py"):
        folder = init.parent
        if folder.relative_to(PACKAGE).as_posix() not in PLUG_INS:
            assert len(list(folder.glob("*.py"))) <= MOST, folder
    assert not {path.name for path in PACKAGE.glob("*.py")} - {"__init__.py"}


def circles(imports):
    """What can be reached from itself."""
    found = set()
    for start in imports:
        seen, waiting = set(), [start]
        while waiting:
            new = set(imports.get(waiting.pop(), ())) - seen
            seen |= new
            waiting += new
        if start in seen:
            found.add(start)
    return found


def test_no_modules_import_each_other_in_a_circle():
    graph = grimp.build_graph("robust_ik", exclude_type_checking_imports=True, cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert len(imports) > 300
    assert circles(imports) == set()
    imports["robust_ik.singularities.atlas.search_state"] |= {"robust_ik.singularities.atlas.atlas"}
    assert "robust_ik.singularities.atlas.atlas" in circles(imports)


SHORT = {"chain_layout": "links", "pose_layout": "lay", "search_memory": "mem", "step_layout": "slots",
         "control_layout": "slots", "second_order_layout": "lay",
         "branches_layout": "lay", "ladder_layout": "lay"}  # fmt: skip
"""Modules of places in vectors, which kernels name in every line: the one short name that each may have."""


def names_of_classes(texts):
    """Class name → the files that define it at their top, of those that more than one does."""
    found = {}
    for name, text in texts.items():
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append(name)
    return {name: files for name, files in found.items() if len(files) > 1}


def renamed_modules(text):
    """Modules of ours that a text imports under another name than their own."""
    imports = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    pairs = [
        (each.name, each.asname) for node in imports for each in node.names if each.asname not in (None, each.name)
    ]
    return [(name, short) for name, short in pairs if (name in MODULES) and SHORT.get(name) != short]


TEXTS = {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
MODULES = {Path(name).stem for name in TEXTS} - {"warmup"}


def test_a_class_has_a_name_of_its_own_and_a_module_is_called_by_its_name():
    assert names_of_classes(TEXTS) == {}
    assert names_of_classes({"a.py": "class Leaf: ...", "b.py": "class Leaf: ..."}) == {"Leaf": ["a.py", "b.py"]}
    assert {name: found for name, text in TEXTS.items() if (found := renamed_modules(text))} == {}
    assert renamed_modules("from robust_ik.kinematics import svd as linalg") == [("svd", "linalg")]


def reached_into(importer, text):
    """Imports of a module inside another room's folder, past what the folder hands on, and of private names."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("robust_ik."):
            continue
        room, *inside = node.module.removeprefix("robust_ik.").split(".")
        if len(inside) >= 2 and room not in (importer.split("/")[0], "kernels"):
            found.append(f"{importer} reaches into {node.module}")
        found += [f"{importer} imports the private {each.name}" for each in node.names if each.name.startswith("_")]
    return found


def test_a_folder_of_another_room_is_used_through_what_it_hands_on():
    """Layouts of kernels are imported one by one: they are no more than numbers."""
    for name, text in TEXTS.items():
        assert reached_into(name, text) == []
    assert reached_into("display/page.py", "from robust_ik.singularities.trace.continuation import follow")
    assert reached_into("display/page.py", "from robust_ik.singularities.trace import _private")
    assert not reached_into("display/page.py", "from robust_ik.singularities.trace import Curve")
    assert not reached_into(
        "singularities/atlas/atlas.py", "from robust_ik.singularities.trace.continuation import follow"
    )


NUMBERS = (ast.Constant, ast.UnaryOp, ast.BinOp, ast.Name, ast.Attribute, ast.operator, ast.unaryop, ast.expr_context)
"""What arithmetic such as -1e-6, 2 * math.pi or HEAD - 8 is made of."""


def constants(statement):
    """The names of a module-level constant that is a number or a tuple of numbers, and no colour; else none."""
    if not isinstance(statement, (ast.Assign, ast.AnnAssign)) or statement.value is None:
        return []
    target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
    colour = isinstance(statement, ast.AnnAssign) and ast.unparse(statement.annotation) == "Color"
    names = [each.id for each in (target.elts if isinstance(target, ast.Tuple) else [target]) if hasattr(each, "id")]
    parts = statement.value.elts if isinstance(statement.value, ast.Tuple) else [statement.value]
    nodes = [node for part in parts for node in ast.walk(part)]
    values = [node.value for node in nodes if isinstance(node, ast.Constant)]
    numeric = all(isinstance(node, NUMBERS) for node in nodes) and {type(value) for value in values} <= {int, float}
    return names if values and numeric and not colour and all(name.isupper() for name in names) else []


def is_text(statement):
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def unexplained(source):
    """Constants of a module that nothing is said of.

    Something is said by a comment at the end of the line, by a string right below, or by one below further such lines
    if it names the first of them.
    """
    body, lines = ast.parse(source).body, source.splitlines()
    for place, statement in enumerate(body):
        names = constants(statement)
        if not names or re.search(r"  # \S", lines[statement.end_lineno - 1]):
            continue
        last = place
        while body[last + 1 :] and constants(body[last + 1]) and body[last + 1].lineno == body[last].end_lineno + 1:
            last += 1
        below = body[last + 1] if body[last + 1 :] else None
        said = is_text(below) and below.lineno == body[last].end_lineno + 1
        if not said or (last > place and not re.search(rf"\b{names[0]}\b", below.value.value)):
            yield from names


SAID = '''
GAIN = 5.0
"""1/s."""
S1, S2 = -1 / 6, 1 / 120
S3 = -1 / 5040
"""S1 to S3: Taylor."""
MOST = 3  # tries
RED: Color = (1.0, 0.0, 0.0, 1.0)
NAMES = ("x", "y")
'''


def test_every_numeric_constant_says_what_it_is_and_where_its_value_comes_from():
    found = {
        path: names for path in PACKAGE.rglob("*.py") if (names := [*unexplained(path.read_text(encoding="utf-8"))])
    }
    assert not found
    assert [*unexplained(SAID)] == []
    assert [*unexplained(SAID.replace("  # tries", ""))] == ["MOST"]
    assert [*unexplained(SAID.replace('"""1/s."""\n', "\n"))] == ["GAIN"]
    assert [*unexplained(SAID.replace('"""S1 to S3: Taylor."""', "\n"))] == ["S1", "S2", "S3"]
    assert [*unexplained(SAID.replace("S1 to S3: ", ""))] == ["S1", "S2"]
    assert [*unexplained("_HALF = 0.5 * math.pi\n")] == ["_HALF"]


SMUGGLED = [
    ("singularities/lost_motion/wrench_screw.py", "import pinocchio", "Pinocchio lives"),
    ("certificates/prover/rational_matrices.py", "import meshcat", "MeshCat lives"),
    ("control/compiled_step/stepper.py", "import matplotlib.pyplot", "Matplotlib lives"),
    ("inverses/jparse.py", "import numba", "Numba lives"),
    ("control/tasks/frame.py", "import coal", "Coal lives"),
    ("certificates/checker/check.py", "import robust_ik.certificates.prover.minors", "Who checks a proof shares"),
    (
        "certificates/checker/leaf_checks.py",
        "import robust_ik.certificates.proof.real_roots",
        "Who checks a proof counts",
    ),
    ("kinematics/svd.py", "import robust_ik.robot.robot", "Imports point down"),
    ("kernels/matrices/small_svd.py", "import robust_ik.kernels.pose.pose_search", "Inside kernels"),
    ("singularities/geometry/screw_chain.py", "import robust_ik.singularities.atlas.atlas", "Inside singularities"),
    ("control/tasks/frame.py", "import robust_ik.control.reaching.reach_task", "Inside control"),
    ("display/scene/scene.py", "import robust_ik.display.pages.atlas_page", "Inside display"),
]


@pytest.mark.slow
def test_an_import_that_is_smuggled_in_breaks_its_contract(tmp_path):
    """All of them at once, each then seen in the contract that is about it."""
    shutil.copytree(PACKAGE, tmp_path / "robust_ik", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for file, line, _ in SMUGGLED:
        with (tmp_path / "robust_ik" / file).open("a", encoding="utf-8") as source:
            source.write(f"\n{line}\n")
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as run; run()", "--no-cache"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    report = " ".join(done.stdout.split())
    for file, line, contract in SMUGGLED:
        assert re.search(rf"{contract}(?:(?!KEPT|BROKEN).)*? BROKEN", report), contract
        module = "robust_ik." + file.removesuffix(".py").replace("/", ".")
        assert f"{module} -> {line.split()[1].split('.')[0] if 'robust_ik' not in line else line.split()[1]}" in report
