"""The documentation site: its reference names everything that is public, and its links are followed."""

import re
import runpy
from pathlib import Path

import pytest

import robust_ik as rik
from robust_ik import certificates, display
from robust_ik.analysis import evaluation, stability

DOCS = Path(__file__).parents[2] / "docs"
REFERENCE = {path.stem: path.read_text(encoding="utf-8") for path in (DOCS / "reference").glob("*.md")}
broken = runpy.run_path(str(DOCS / "site" / "check_links.py"))["broken"]
OWN_PAGES = {"certificates": certificates, "display": display, "evaluation": evaluation, "stability": stability}


def named(page):
    return re.findall(r"^\.\. auto\w+:: (\w+)$", page, re.MULTILINE)


def test_the_reference_has_every_public_name_once():
    found = [name for page, text in REFERENCE.items() if page not in OWN_PAGES for name in named(text)]
    assert sorted(found) == sorted(
        set(rik.__all__) - {"__version__", "inverses", "certificates", "evaluation", "stability"}
    )


@pytest.mark.parametrize("page", OWN_PAGES)
def test_a_sub_package_has_a_page_with_all_of_its_names(page):
    assert sorted(named(REFERENCE[page])) == sorted(OWN_PAGES[page].__all__)


def test_every_page_is_in_the_table_of_contents():
    listed = re.findall(r"^(?:\.\./)?[\w/]+$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.rglob("*.md")} - {"index"}
    assert pages <= set(listed)


@pytest.mark.parametrize(
    ("html", "complaint"),
    [
        ('<a href="b.html#place">there</a>', ""),
        ('<a href="#here">here</a><p id="here"></p>', ""),
        ('<a href="https://example.org/nowhere">elsewhere</a>', ""),
        ('<a href="c.html">gone</a>', "a.html links to c.html: there is no such file"),
        ('<a href="b.html#gone">gone</a>', "a.html links to b.html#gone: there is no such place"),
        ('<img src="picture.svg">', "a.html links to picture.svg: there is no such file"),
        ('<script src="https://example.org/x.js"></script>', "a.html loads https://example.org/x.js"),
    ],
)
def test_a_link_that_leads_nowhere_is_found(tmp_path, html, complaint):
    (tmp_path / "a.html").write_text(html, encoding="utf-8")
    (tmp_path / "b.html").write_text('<h1 id="place">Place</h1>', encoding="utf-8")
    assert broken(tmp_path) == ([complaint] if complaint else [])
