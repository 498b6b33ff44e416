"""The page in a real browser: `make test-long`, where chromium is installed."""

from __future__ import annotations

import base64
import re
import shutil
import time
from dataclasses import replace
from pathlib import Path

import pytest
from exact_campaign import campaign, searched

from browser import Browser, Tab
from pipeline import figures
from pipeline.campaign import Campaign
from pipeline.report.overlay import trial_overlay
from pipeline.report.page import write_report

pytestmark = pytest.mark.long

PROBE = """(async () => {
  const headings = [...document.querySelectorAll("#trial-table thead button")];
  const cells = () => [...document.querySelectorAll("#trial-table tbody tr")]
    .map((row) => Number(row.cells[5].dataset.key));
  headings[5].focus(); headings[5].click();
  const up = cells(); headings[5].click(); const down = cells();
  const video = document.querySelector("video");
  video.scrollIntoView();
  await new Promise((done) => { video.oncanplay = done; setTimeout(done, 8000); });
  await video.play();
  await new Promise((done) => setTimeout(done, 800));
  const field = document.getElementById("filter");
  field.value = "straight"; field.dispatchEvent(new Event("input"));
  const left = document.querySelectorAll("#trial-table tbody tr:not([hidden])").length;
  return { up, down, left, time: video.currentTime, size: [video.videoWidth, video.videoHeight],
    focus: document.activeElement === headings[5], images: document.images.length,
    blank: [...document.images].filter((image) => !image.naturalWidth).length,
    wide: document.documentElement.scrollWidth - document.documentElement.clientWidth };
})()"""
FOCUSED = "(() => { const e = document.activeElement, s = getComputedStyle(e); return " \
    "[e.tagName, e.textContent.trim(), e.closest('table') ? e.closest('table').id : '', " \
    "s.outlineStyle, parseFloat(s.outlineWidth)]; })()"  # fmt: skip
SMALLEST = """(() => Math.min(...
  [...document.querySelectorAll("p, td, th, li, figcaption, summary")]
  .filter((e) => e.getClientRects().length && e.textContent.trim())
  .map((e) => parseFloat(getComputedStyle(e).fontSize))))()"""
OFFSCREEN = """(() => [...document.querySelectorAll("body *")].filter((e) => {
  const box = e.getBoundingClientRect();
  return box.width && box.right > innerWidth + 1 && !e.closest(".scroll, figure, svg, .skip");
}).map((e) => e.tagName + "." + e.className))()"""


def told() -> dict[str, tuple[str, str]]:
    return {name: (figures.title(name), figures.caption(name)) for name in figures.names()}


def written(base: Campaign, folder: Path) -> Path:
    page = folder / "report.html"
    write_report(base, told(), folder / "figures", folder / "overlays", page)
    return page


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    """The page of a campaign with two figures and one film."""
    folder, found = tmp_path_factory.mktemp("page"), searched(campaign())
    for name in ("fig3", "mismatch_map"):
        draw = folder / "figures" / name
        figures.draw_file(name, found, draw.with_suffix(".png"), draw.with_suffix(".pdf"))
    trial_overlay(found, "T02", folder, folder / "overlays" / "T02.mp4")
    return written(found, folder)


@pytest.fixture
def browser(tmp_path):
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no chromium here")
    one = Browser(program, tmp_path / "profile", 1280)
    yield one
    one.close()


@pytest.mark.parametrize("phone", [False, True])
def test_it_opens_sorts_filters_and_plays_without_a_word_on_the_console(page, browser, phone):
    tab = Tab(browser, page, phone=phone)
    seen = tab.tell(PROBE)
    assert tab.complaints() == []
    assert seen["up"] == sorted(seen["up"])
    assert seen["down"] == sorted(seen["up"], reverse=True)
    assert seen["left"] == 6  # one straight run a power and head
    assert (seen["images"], seen["blank"], seen["size"]) == (2, 0, [640, 400])
    assert seen["time"] > 0.2
    assert seen["focus"]
    assert seen["wide"] <= 0


def test_it_can_be_read_on_a_phone(page, browser):
    tab = Tab(browser, page, phone=True)
    assert tab.tell("document.documentElement.clientWidth") == 390
    assert tab.tell(SMALLEST) >= 12
    assert tab.tell(OFFSCREEN) == []


def test_the_keyboard_reaches_and_sorts_with_a_ring_around_what_has_the_focus(page, browser):
    tab = Tab(browser, page)
    tab.press("Tab", 9)
    assert "Skip" in tab.tell(FOCUSED)[1]
    for _ in range(60):
        tab.press("Tab", 9)
        tag, text, table, style, width = tab.tell(FOCUSED)
        assert style != "none", (tag, text)
        assert width >= 2, (tag, text)
        if tag == "BUTTON" and table == "trial-table":
            break
    assert (tag, table) == ("BUTTON", "trial-table")
    tab.press("Enter", 13, "\r")
    heading = "document.activeElement.closest('th').getAttribute('aria-sort')"
    assert tab.tell(heading) == "ascending"
    tab.press("Enter", 13, "\r")
    assert tab.tell(heading) == "descending"


def test_on_paper_nothing_is_hidden_or_cut_off(page, browser):
    tab = Tab(browser, page)
    tab.call("Emulation.setEmulatedMedia", media="print")
    assert tab.tell("getComputedStyle(document.querySelector('nav')).display") == "none"
    done = tab.call("Page.printToPDF", paperWidth=8.27, paperHeight=11.69)
    pdf = base64.b64decode(done["data"])
    assert pdf.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) >= 4
    assert tab.tell("[...document.querySelectorAll('details')].every((part) => part.open)")
    assert tab.complaints() == []


def test_the_page_of_a_thousand_trials_opens_and_sorts_at_once(tmp_path, browser):
    few = searched(campaign())
    ids = [trial.trial_id for trial in few.study.trials]
    trials = [
        few.study.trial(ids[k % len(ids)]).model_copy(update={"trial_id": f"N{k:04d}"})
        for k in range(1000)
    ]
    of = {trial.trial_id: ids[k % len(ids)] for k, trial in enumerate(trials)}
    many = replace(
        few,
        study=few.study.model_copy(update={"trials": tuple(trials)}),
        tracks={name: few.tracks[old] for name, old in of.items()},
        steady={name: few.steady[old] for name, old in of.items()},
    )
    page = written(many, tmp_path)
    assert page.stat().st_size < 5_000_000
    start = time.monotonic()
    tab = Tab(browser, page)
    assert time.monotonic() - start < 15
    rows = "document.querySelectorAll('#trial-table tbody tr').length"
    assert tab.tell(rows) == 1000
    sort = "(() => { const t = performance.now(); document.querySelectorAll(" \
        "'#trial-table thead button')[5].click(); return performance.now() - t; })()"  # fmt: skip
    assert tab.tell(sort) < 2000
    assert tab.complaints() == []
