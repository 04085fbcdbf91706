"""What is too much is refused before it is read, and messages stay short whatever they quote."""

import contextlib
import pickle

import pytest

import robust_ik as rik
from robust_ik.description import xml_size_limits
from robust_ik.description.catalog import catalog
from robust_ik.description.joint_tree import Description
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf.urdf_checks import safe_tree
from robust_ik.description.urdf.urdf_reader import parse_urdf
from robust_ik.description.xml_size_limits import SRDF, URDF
from robust_ik.errors import LONGEST_MESSAGE, cut, listed, suggest

ROBOT = '<robot name="r"><link name="a"/>{}</robot>'
ATTRIBUTES = " ".join(f"a{i}=''" for i in range(9000))
NAMESPACES = " ".join(f"xmlns:n{i}='u'" for i in range(5000))
MANY = {
    "elements": (URDF.elements * "<a/>", "elements; a URDF of over"),
    "elements in a link": ("<link name='b'>" + URDF.elements * "<a/>" + "</link>", "elements; a URDF of over"),
    "joints": (8_001 * "<joint/>", "8001 elements <joint>; a URDF of over 8000"),
    "meshes": (5_001 * "<mesh/>", "5001 elements <mesh>"),
    "attributes": (f"<a {ATTRIBUTES}/>", "element <a> has about 9000 attributes"),
    "attributes after a bracket": (f'<a b=">" {ATTRIBUTES}/>', "attributes"),
    "namespaces": (f"<a {NAMESPACES}/>", "attributes"),
    "an attribute": ('<a b="' + 200_000 * "1 " + '"/>', "start tag of over 100000 bytes"),
    "an attribute without end": ('<a b="' + 200_000 * "1 ", "start tag of over"),
    "very many attributes": ("<a " + 4_000_000 * "b='' " + "/>", "start tag of over"),
    "comments": (2_100_000 * "<!---->", "tags and comments"),
}


@pytest.fixture
def unread(monkeypatch):
    """Fails where a reader of XML is asked."""

    def never(*_, **__):
        raise AssertionError("it was read")

    monkeypatch.setattr("robust_ik.description.urdf.urdf_checks.etree.fromstring", never)


@pytest.mark.parametrize("many", MANY)
def test_a_file_that_holds_too_much_is_refused_before_it_is_read(unread, many):
    inside, message = MANY[many]
    for text in (ROBOT.format(inside), ROBOT.format(inside).encode()):
        with pytest.raises(rik.UrdfError, match=message):
            parse_urdf(text)
    with pytest.raises(rik.UrdfError, match="elements"):
        SRDF.check(ROBOT.format(SRDF.elements * "<a/>"))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-8-sig", "latin-1"])
def test_an_encoding_hides_nothing(unread, encoding):
    text = f'<?xml version="1.0" encoding="{encoding}"?>' + ROBOT.format(8_001 * "<joint/>")
    with pytest.raises(rik.UrdfError, match="8001 elements <joint>"):
        parse_urdf(text.encode(encoding))


@pytest.mark.parametrize("encoding", ["UTF-7", "utf7", "cp037", "IBM500", "EBCDIC-CP-US", "nonsense", "rot13"])
def test_an_encoding_that_could_hide_brackets_is_never_believed(encoding):
    declaration = f'<?xml version="1.0" encoding="{encoding}"?>'.encode()
    assert parse_urdf(declaration + ROBOT.format("").encode()).links == ("a",)
    for hidden in (ROBOT.format(8_001 * "<joint/>").encode("cp037"), b"+ADw-robot+AD4-+ADw-/robot+AD4-"):
        with pytest.raises(rik.UrdfError, match="not well-formed"):
            parse_urdf(declaration + hidden)
        with pytest.raises(rik.UrdfError, match="not well-formed"):
            parse_urdf(hidden)


def test_what_was_mended_is_counted_again():
    prefixes = "".join(f"<p{i}:a/>" for i in range(2000))
    with pytest.raises(rik.UrdfError, match="<robot> has about 2001 attributes"):
        parse_urdf(ROBOT.format(prefixes))


def test_long_texts_comments_and_data_are_no_tags():
    inside = f"<d>{'a = b, ' * 20_000}</d><!--{'x = y ' * 50_000}--><d><![CDATA[{'c = d; ' * 50_000}]]></d>"
    assert safe_tree(ROBOT.format(inside)).find("d") is not None


def test_real_robots_are_a_tenth_of_what_is_allowed():
    tenth = xml_size_limits.XmlBounds(
        "a robot", URDF.elements // 10, tuple((name, most // 10) for name, most in URDF.of), 50, 10_000
    )
    paths = [entry.path for entry in catalog().values() if entry.path.suffix == ".urdf"]
    assert len(paths) > 50
    for path in paths:
        tenth.check(path.read_bytes())


# ------------------------------------------------------------------------------------------ messages
def test_no_message_is_longer_than_a_screen_and_its_ends_are_kept():
    for kind in (rik.RobustIKError, rik.InputError, rik.UrdfError, rik.TipError, rik.FrameNotFoundError):
        error = kind("begin" + "x" * 8_000_000 + "end")
        assert len(str(error)) <= LONGEST_MESSAGE
        assert str(error).startswith("begin")
        assert str(error).endswith("end")
        assert str(pickle.loads(pickle.dumps(error))) == str(error)
    assert str(rik.InputError("short")) == "short"


def test_names_that_are_long_or_many_are_shortened_in_lists():
    names = [f"{i:05}" + "n" * 10_000 for i in range(10_000)]
    assert len(listed(names)) < 6_000
    assert listed(names).endswith("(10000 in all)")
    assert len(suggest("n" * 100, names)) < 6_000
    assert suggest("tool", ["tool0", "base"]) == "did you mean 'tool0'? there are: base, tool0"


@pytest.mark.parametrize("most", [20, 100, 1001])
def test_what_is_cut_is_as_long_as_allowed(most):
    assert len(cut("x" * 5000, most)) == most
    assert cut("x" * most, most) == "x" * most


@pytest.mark.parametrize("length", [10_000, 90_000])
def test_a_message_that_quotes_a_file_is_short(length):
    long = "n" * length
    for inside in (
        f'<link name="{long}"/><link name="{long}"/>',
        f'<joint name="{long}" type="{long}"/>',
        f'<joint name="j" type="fixed"><parent link="{long}"/></joint>',
        f'<link name="b"><inertial><origin xyz="{long}"/></inertial></link>',
    ):
        with pytest.raises(rik.UrdfError) as caught:
            parse_urdf(ROBOT.format(inside))
        assert len(str(caught.value)) <= LONGEST_MESSAGE


@pytest.mark.parametrize("kind", ["revolute", "follower", "fixed"])
def test_to_choose_a_tip_takes_no_more_than_some_looks_at_each_link(kind, monkeypatch):
    looks, chain = [], Description.chain
    monkeypatch.setattr(Description, "chain", lambda self, frame: looks.append(frame) or chain(self, frame))
    limit = "<limit lower='-1' upper='1' velocity='1' effort='1'/>"
    joint = "<link name='{2}'/><joint name='j{2}' type='{0}'><parent link='{1}'/><child link='{2}'/><axis xyz='0 0 1'/>"
    end = limit + ("<mimic joint='jb'/>" if kind == "follower" else "") + "</joint>"
    turns = "fixed" if kind == "fixed" else "revolute"
    joints = [(joint + end).format(turns, "a" if kind == "follower" else "b", f"l{i}") for i in range(500)]
    first = (joint + limit + "</joint>").format("revolute", "a", "b")
    description = parse_urdf(ROBOT.format(first + "".join(joints)))
    with contextlib.suppress(rik.TipError):
        choose_tip(description)
    assert len(looks) <= 20 * 500  # and not 500²
