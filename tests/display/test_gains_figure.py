"""The figure of gains, and the command that draws it."""

import pytest

import robust_ik as rik
from robust_ik.display import plot_gains
from robust_ik.display.figures.gains import label
from robust_ik.inverses import CLASSES

FILTERS = [each() for each in CLASSES if issubclass(each, rik.SingularValueFilter)]


@pytest.mark.parametrize("suffix, start", [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_the_figure_of_all_filters_is_written(suffix, start, tmp_path):
    path = plot_gains(FILTERS, tmp_path / "new" / f"gains{suffix}")
    assert path.read_bytes().startswith(start)


def test_labels_give_parameters_that_are_not_the_default():
    assert label(rik.JParse()) == "JParse"
    assert label(rik.JParse(gamma=0.2)) == repr(rik.JParse(gamma=0.2))


@pytest.mark.parametrize(
    "filters, path, match",
    [
        ([], "x.png", "at least one"),
        ([rik.SDLS()], "x.png", "only singular-value filters"),
        (FILTERS, "x.gif", r"one of \.png, \.svg, \.pdf, got 'x\.gif'"),
        (FILTERS, "x", "one of"),
    ],
)
def test_what_cannot_be_drawn_is_refused(filters, path, match):
    with pytest.raises(rik.InputError, match=match):
        plot_gains(filters, path)
