"""What docs/loading.md says: its example loads, its names exist."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description import catalog

PAGE = (Path(__file__).parents[2] / "docs" / "loading.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    path = tmp_path_factory.mktemp("sheet") / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return rik.load(path)


def test_the_table_of_the_data_sheet_loads_with_its_limits(sheet):
    assert (sheet.name, sheet.n) == ("ur5e_sheet", 6)
    assert_allclose(sheet.upper, 2 * np.pi)
    assert_allclose(sheet.velocity_limit, np.pi)


def test_its_pose_at_zero_is_what_the_lengths_add_up_to(sheet):
    # Arm stretched along −x, the flange towards −y: a₂ + a₃, −(d₄ + d₆ + tool), d₁ − d₅.
    expected = [-0.425 - 0.3922, -(0.1333 + 0.0996 + 0.15), 0.1625 - 0.0997]
    assert_allclose(sheet.pose(sheet.neutral)[:3, 3], expected, atol=1e-12)


def test_the_robots_and_tips_it_names_are_there():
    assert rik.load("panda").tip == "panda_hand_tcp"
    assert rik.load(catalog.find("panda").path).tip == "panda_hand"


def test_the_options_it_names_exist():
    import inspect

    for option in ("tip", "package_dirs", "whole_tree", "xacro_args"):
        assert f"{option}=" in PAGE
        assert option in inspect.signature(rik.load).parameters
