"""Robots of robot_descriptions: by name, by its full name, as a module; only names of its own list are imported."""

import importlib.machinery
import sys
from types import ModuleType, SimpleNamespace

import pytest

import robust_ik as rik
from robust_ik.description.catalog import catalog


@pytest.fixture
def descriptions(monkeypatch):
    """The package, with a robot that is there, one that cannot be fetched, one that is MJCF."""
    package = ModuleType("robot_descriptions")
    package.__spec__ = importlib.machinery.ModuleSpec("robot_descriptions", None, is_package=True)
    package.__path__ = []
    package.DESCRIPTIONS = dict.fromkeys(["panda_description", "far_description", "shadow_mj_description"])
    monkeypatch.setitem(sys.modules, "robot_descriptions", package)
    panda = ModuleType("robot_descriptions.panda_description")
    panda.URDF_PATH = str(catalog()["panda"].path)
    panda.PACKAGE_PATH = panda.REPOSITORY_PATH = str(catalog()["panda"].path.parents[1])
    mujoco = ModuleType("robot_descriptions.shadow_mj_description")
    mujoco.MJCF_PATH = "x.xml"
    for module in (panda, mujoco):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    return SimpleNamespace(package=package, panda=panda)


def test_a_robot_of_robot_descriptions_loads_by_name_and_as_a_module(descriptions):
    for given in ("panda_description", "robot_descriptions.panda_description", descriptions.panda):
        robot = rik.load(given)
        assert (robot.name, robot.n, robot.tip) == ("panda_description", 7, "panda_hand")
    assert rik.load("panda_description", "panda_link8").tip == "panda_link8"


def test_what_cannot_be_fetched_is_one_sentence(descriptions):
    with pytest.raises(rik.LoadError, match="could not fetch 'far_description', which it downloads at its first use"):
        rik.load("far_description")


def test_a_robot_without_urdf_is_refused(descriptions):
    with pytest.raises(rik.LoadError, match="has no URDF.*It has MJCF"):
        rik.load("shadow_mj_description")
    with pytest.raises(rik.LoadError, match="'math' has no URDF"):
        rik.load(importlib.import_module("math"))


@pytest.mark.parametrize(
    "name", ["robot_descriptions.antigravity", "robot_descriptions.os", "robot_descriptions._cache"]
)
def test_only_names_of_the_list_are_imported(descriptions, name):
    before = set(sys.modules)
    with pytest.raises(rik.RobotNotFoundError, match="robot_descriptions has no '.*there are: far_description"):
        rik.load(name)
    assert set(sys.modules) == before


def test_names_of_ours_come_first_and_others_are_not_found(descriptions):
    assert rik.load("panda").description.file == catalog()["panda"].path
    with pytest.raises(rik.RobotNotFoundError, match="no robot called 'antigravity'"):
        rik.load("antigravity")


def test_without_the_package_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    for name in ("some_description", "robot_descriptions.some_description"):
        with pytest.raises(rik.RobotNotFoundError, match="pip install robot_descriptions"):
            rik.load(name)


def test_xacro_of_robot_descriptions_is_expanded_with_its_arguments(tmp_path, descriptions, monkeypatch):
    pytest.importorskip("xacrodoc")
    (tmp_path / "arm_description").mkdir()
    path = tmp_path / "arm_description/arm.xacro"
    path.write_text(
        '<robot name="arm" xmlns:xacro="http://x"><xacro:arg name="kind" default=""/><link name="a"/><link name="b"/>'
        '<joint name="j" type="$(arg kind)"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>'
    )
    module = ModuleType("robot_descriptions.arm_description")
    module.XACRO_PATH, module.XACRO_ARGS = str(path), {"kind": "continuous"}
    module.XACRO_PACKAGE_PATHS = {"arm_description": str(path.parent)}
    module.PACKAGE_PATH = module.REPOSITORY_PATH = str(path.parent)
    assert rik.load(module).n == 1
    with pytest.raises(rik.TipError):
        rik.load(module, xacro_args={"kind": "fixed"})
