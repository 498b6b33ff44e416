"""The built documentation: complete, self-contained, and searchable from file:// without errors."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from browser import PAGE_READY_SCRIPT, Browser, Tab

# `.ci/run` builds the site and checks its links by `make docs`
pytestmark = pytest.mark.long

DOCS = Path(__file__).resolve().parents[1] / "docs"
SEARCHED = """new Promise((found) => {
  const began = Date.now();
  const look = () => {
    const links = [...document.querySelectorAll('#search-results li a')].map(a => a.textContent);
    if (links.includes('How the finder works') || Date.now() - began > 20000) found(links);
    else setTimeout(look, 50);
  }; look(); })"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, as `make docs` builds it."""
    pytest.importorskip("sphinx")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    done = subprocess.run([*command, "-d", folder / "doctrees", DOCS, folder / "html"],
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "html"


@pytest.fixture
def tab(site, tmp_path):
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no chromium here")
    one = Browser(program, tmp_path / "profile", 1280)
    yield lambda page: Tab(one, page)
    one.close()


def test_every_link_and_anchor_leads_somewhere_and_nothing_is_remote(site):
    spec = importlib.util.spec_from_file_location("check_site", DOCS / "check_site.py")
    checker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(checker)
    assert list(checker.faults(site)) == []


def test_search_finds_pages_without_a_server(site, tab):
    page = tab(site / "index.html")
    form = "document.querySelector('[role=search]')"
    assert page.evaluate(f"{form}.action") == (site / "search.html").as_uri()
    name = page.evaluate(f"{form}.querySelector('input').name")
    page.call("Page.navigate", url=f"{(site / 'search.html').as_uri()}?{name}=credible+set")
    page.evaluate(PAGE_READY_SCRIPT)
    assert "How the finder works" in page.evaluate(SEARCHED)
    assert page.console_messages() == []


def test_pages_open_without_console_messages_and_fit_the_window(site, tab):
    page = tab(site / "index.html")
    wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    for name in ("index", "api", "study_keys", "finder", "evidence"):
        page.call("Page.navigate", url=(site / f"{name}.html").as_uri())
        page.evaluate(PAGE_READY_SCRIPT)
        assert page.evaluate(wide) <= 0, name
        assert page.evaluate("document.querySelectorAll('.sidebar-tree a').length") > 15
    assert page.console_messages() == []
