"""The page in real browsers: `make test-long`, where chromium and firefox are installed."""

from __future__ import annotations

import base64
import re
import shutil
import time
from dataclasses import replace
from pathlib import Path

import pytest
from exact_campaign import campaign_with_damping_found, exact_campaign
from firefox import Firefox, FirefoxTab

from bluekoi import figures
from bluekoi.campaign import Campaign
from bluekoi.report.overlay import write_trial_overlay
from bluekoi.report.page import write_report
from browser import Browser, Tab

pytestmark = pytest.mark.long

PAGE_STATE_SCRIPT = """(async () => {
  const headings = [...document.querySelectorAll("#trial-table thead button")];
  const cells = () => [...document.querySelectorAll("#trial-table tbody tr")]
    .map((row) => Number(row.cells[5].dataset.key));
  headings[5].focus(); headings[5].click();
  const up = cells(); headings[5].click(); const down = cells();
  const focus = document.activeElement === headings[5];
  location.hash = "trial-T02";
  const video = document.querySelector("video");
  await new Promise((done) => { video.oncanplay = done; setTimeout(done, 8000); });
  document.getElementById("explorer-play").click();
  for (let k = 0; k < 100 && !(video.currentTime > 0.3 && now.time > 0.3); k += 1) {
    await new Promise((done) => setTimeout(done, 100));
  }
  const time = Number(document.getElementById("explorer-time").value);
  const [film, size] = [video.currentTime, [video.videoWidth, video.videoHeight]];
  const field = document.getElementById("filter");
  field.value = "straight"; field.dispatchEvent(new Event("input"));
  const left = document.querySelectorAll("#trial-table tbody tr:not([hidden])").length;
  const listed = document.querySelectorAll("#explorer-select option").length;
  return { up, down, left, listed, time, film, size, focus,
    images: document.images.length,
    blank: [...document.images].filter((image) => !image.naturalWidth).length,
    wide: document.documentElement.scrollWidth - document.documentElement.clientWidth };
})()"""
WAIT_SCRIPT = """new Promise((done) => {
  const end = performance.now() + 20000;
  const look = () => {
    if (CONDITION) done(true);
    else if (performance.now() > end) done(false);
    else setTimeout(look, 30);
  };
  look();
})"""
EXPLORER_STATE_SCRIPT = """[document.activeElement.id, now.id,
  Number(document.getElementById("explorer-time").value),
  document.getElementById("explorer-play").textContent]"""
FOCUSED_ELEMENT_SCRIPT = (
    "(() => { const e = document.activeElement, s = getComputedStyle(e); return "
    "[e.tagName, e.textContent.trim(), e.closest('th') ? e.closest('table').id : '', "
    "s.outlineStyle, parseFloat(s.outlineWidth)]; })()"
)
SMALLEST_FONT_SCRIPT = """(() => Math.min(...
  [...document.querySelectorAll("p, td, th, li, figcaption, summary")]
  .filter((e) => e.getClientRects().length && e.textContent.trim())
  .map((e) => parseFloat(getComputedStyle(e).fontSize))))()"""
OFFSCREEN_ELEMENTS_SCRIPT = """(() => [...document.querySelectorAll("body *")].filter((e) => {
  const box = e.getBoundingClientRect();
  return box.width && box.right > innerWidth + 1 &&
    !e.closest(".scroll, figure, svg, .skip, .chart");
}).map((e) => e.tagName + "." + e.className))()"""


BROKEN_WORDS_JS = """(() => [...document.querySelectorAll("#explorer-readout th")].filter((e) => {
  const range = document.createRange();
  return [...e.firstChild.data.matchAll(/\\S+/g)].some((word) => {
    range.setStart(e.firstChild, word.index);
    range.setEnd(e.firstChild, word.index + word[0].length);
    return new Set([...range.getClientRects()].map((box) => box.top)).size > 1;
  });
}).map((e) => e.textContent))()"""
READOUT_OVERHANG_SCRIPT = """(() => { const t = document.getElementById("explorer-readout");
  return t.scrollWidth - t.parentElement.clientWidth; })()"""
CUT_CAPTIONS_SCRIPT = """(() => [...document.querySelectorAll("caption")].filter((e) =>
  e.getClientRects().length && e.getBoundingClientRect().right > innerWidth)
  .map((e) => e.textContent))()"""


def figure_texts() -> dict[str, tuple[str, str]]:
    return {
        name: (figures.figure_title(name), figures.figure_caption(name))
        for name in figures.figure_names()
    }


def write_page(base: Campaign, folder: Path) -> Path:
    page = folder / "report.html"
    write_report(base, figure_texts(), folder / "figures", folder / "overlays", page)
    return page


def repeated_trials(few: Campaign, count: int) -> Campaign:
    """The trials of a campaign again and again under new names."""
    ids = [trial.trial_id for trial in few.study.trials]
    trials = [
        few.study.trial(ids[k % len(ids)]).model_copy(update={"trial_id": f"N{k:04d}"})
        for k in range(count)
    ]
    of = {trial.trial_id: ids[k % len(ids)] for k, trial in enumerate(trials)}
    return replace(
        few,
        study=few.study.model_copy(update={"trials": tuple(trials)}),
        tracks={name: few.tracks[old] for name, old in of.items()},
        steady={name: few.steady[old] for name, old in of.items()},
    )


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    """The page of a campaign with two figures and one video."""
    folder, found = tmp_path_factory.mktemp("page"), campaign_with_damping_found(exact_campaign())
    for name in ("fig3", "mismatch_map"):
        draw = folder / "figures" / name
        figures.write_figure_files(name, found, draw.with_suffix(".png"), draw.with_suffix(".pdf"))
    write_trial_overlay(found, "T02", folder, folder / "overlays" / "T02.mp4")
    return write_page(found, folder)


@pytest.fixture
def browser(tmp_path):
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no chromium here")
    one = Browser(program, tmp_path / "profile", 1280)
    yield one
    one.close()


@pytest.fixture
def firefox(tmp_path):
    program = shutil.which("firefox") or shutil.which("firefox-esr")
    if program is None:
        pytest.skip("no firefox here")
    one = Firefox(program, tmp_path / "firefox")
    yield one
    one.close()


@pytest.mark.parametrize("phone", [False, True])
def test_it_opens_sorts_filters_and_plays_without_console_messages(page, browser, phone):
    tab = Tab(browser, page, phone=phone)
    seen = tab.evaluate(PAGE_STATE_SCRIPT)
    assert tab.console_messages() == []
    assert seen["up"] == sorted(seen["up"])
    assert seen["down"] == sorted(seen["up"], reverse=True)
    assert seen["left"] == seen["listed"] == 6  # one straight run per power and head
    assert (seen["images"], seen["blank"], seen["size"]) == (2, 0, [640, 400])
    assert seen["time"] > 0.2
    assert seen["film"] > 0.2
    assert seen["focus"]
    assert seen["wide"] <= 0


def wait_for(tab: Tab, condition: str) -> None:
    assert tab.evaluate(WAIT_SCRIPT.replace("CONDITION", condition)), condition


@pytest.mark.parametrize("phone", [False, True])
def test_the_explorer_works_by_keyboard_alone(page, browser, phone):
    tab = Tab(browser, page, phone=phone)
    explore_by_keyboard(tab)
    assert tab.evaluate("now.id") == "T02"


@pytest.mark.parametrize("phone", [False, True])
def test_the_explorer_works_by_keyboard_alone_in_firefox(page, firefox, phone):
    tab = FirefoxTab(firefox, page, phone=phone)
    assert tab.evaluate("innerWidth") == (390 if phone else 1300)
    explore_by_keyboard(tab)


def explore_by_keyboard(tab: Tab | FirefoxTab) -> None:
    for _ in range(200):
        tab.press("Tab", 9)
        if tab.evaluate("document.activeElement.matches('a[href=\"#trial-T02\"]')"):
            break
    tab.press("Enter", 13, "\r")
    wait_for(tab, "now.id === 'T02' && now.drawn")
    assert tab.evaluate(EXPLORER_STATE_SCRIPT) == ["explorer", "T02", 0, "Play"]
    tab.press("ArrowRight", 39)
    assert tab.evaluate(EXPLORER_STATE_SCRIPT)[2] == pytest.approx(1 / 30, abs=2e-4)
    tab.press("End", 35)
    assert tab.evaluate(EXPLORER_STATE_SCRIPT)[2] == pytest.approx(89 / 30, abs=2e-4)
    wait_for(tab, "!document.querySelector('video').seeking")
    tab.press("Home", 36)
    tab.press("+", 187, "+")
    wait_for(tab, "document.getElementById('explorer-series').layout.xaxis.range[1] < 2")
    tab.evaluate("document.getElementById('explorer-rate').value = '0.25'")
    tab.press(" ", 32, " ")
    wait_for(tab, "now.time > 0.1 && now.playing")
    tab.press(" ", 32, " ")
    assert tab.evaluate(EXPLORER_STATE_SCRIPT)[3] == "Play"
    tab.press("n", 78, "n")
    wait_for(tab, "now.id === 'T03' && now.drawn")
    tab.press("Escape", 27)
    assert tab.evaluate("document.activeElement.getAttribute('href')") == "#trial-T03"
    tab.evaluate("document.getElementById('filter').focus()")
    for letter in "t02":
        tab.press(letter, ord(letter.upper()), letter)
    wait_for(tab, "document.querySelectorAll('#trial-table tbody tr:not([hidden])').length === 1")
    wait_for(tab, "now.id === 'T02' && now.drawn")
    tab.press("Escape", 27)
    wait_for(tab, "document.querySelectorAll('#trial-table tbody tr[hidden]').length === 0")
    assert tab.console_messages() == []


def test_play_right_after_a_jump_begins_at_the_time_jumped_to(page, firefox):
    """The video is then still at the place before: at its end, it stopped at once."""
    tab = FirefoxTab(firefox, page)
    tab.evaluate("location.hash = 'trial-T02'")
    wait_for(tab, "now.id === 'T02' && now.drawn && document.querySelector('video').readyState > 1")
    tab.evaluate("jump(1e9)")
    wait_for(tab, "!document.querySelector('video').seeking")
    assert tab.evaluate("(() => { jump(-1e9); toggle(); return now.time; })()") == 0
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert tab.evaluate("now.time") < 2.5
    wait_for(tab, "now.playing && now.time > 0.1 && now.time < 2.5")


def test_the_explorer_shows_the_values_of_the_track(page, browser):
    base = campaign_with_damping_found(exact_campaign())
    tab = Tab(browser, page)
    tab.evaluate("location.hash = 'trial-T02'")
    wait_for(tab, "now.id === 'T02' && now.drawn")
    tab.evaluate("seek(1.5)")
    cells = "[...document.querySelectorAll('#explorer-readout tbody tr')].map((r) => " \
        "[r.cells[0].textContent, r.cells[1].textContent])"  # fmt: skip
    shown, track = dict(tab.evaluate(cells)), base.tracks["T02"]
    assert shown["x"] == f"{track.x_m[45]:.3f} m"
    assert shown["speed"].startswith(f"{track.speed_m_s[45]:.3f} ± 0.002")
    assert shown["yaw rate"].endswith(" rad/s")
    assert tab.evaluate("document.getElementById('explorer-series').layout.xaxis"
                        ".unifiedhovertitle.text") == "time %{x:.2f} s"  # fmt: skip
    tab.evaluate("now.data.measured.speed_m_s_std.fill(1.4e-4); readout()")
    shown = dict(tab.evaluate(cells))
    assert shown["speed"] == f"{track.speed_m_s[45]:.4f} ± 0.0003 m/s"
    stored = tab.evaluate("now.data.measured.x_m")
    assert stored == pytest.approx(track.x_m.tolist(), abs=5.1e-5)


def test_tables_figures_and_trials_are_downloaded_as_csv(page, browser, tmp_path):
    tab = Tab(browser, page)
    browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    tab.evaluate("location.hash = 'trial-T02'")
    wait_for(tab, "now.id === 'T02' && now.drawn")
    for place in ("#trial-table", "#figure-fig3", "#explorer"):
        click = "'#explorer-csv'" if place == "#explorer" else f"'{place} .download'"
        tab.evaluate(f"document.querySelector({click}).click()")
    names = {"all_trials_of_the_study.csv", "fig3.csv", "T02.csv"}
    end = time.monotonic() + 20
    while time.monotonic() < end and {p.name for p in tmp_path.glob("*.csv")} < names:
        tab.evaluate("new Promise((done) => setTimeout(done, 100))")
    found = {p.name: p.read_text().splitlines() for p in tmp_path.glob("*.csv")}
    assert found.keys() == names
    assert len(found["all_trials_of_the_study.csv"]) == 1 + len(exact_campaign().study.trials)
    assert found["T02.csv"][0].startswith("time_s,x_m,y_m,speed_m_s")
    assert found["fig3.csv"][0].startswith("panel,title,x_label,y_label")


def test_a_click_in_an_interactive_figure_opens_the_trial(page, browser):
    tab = Tab(browser, page)
    tab.evaluate("document.querySelector('#figure-fig3 details').open = true")
    wait_for(tab, "document.querySelector('#figure-fig3 .panels').dataset.ready")
    heights = (
        "[...document.querySelectorAll('#figure-fig3 .chart')].map((c) => c._fullLayout._size.h)"
    )
    assert min(tab.evaluate(heights)) > 200  # the legend does not take the height of the plot
    trial = tab.evaluate("""(() => {
      const charts = [...document.querySelectorAll("#figure-fig3 .chart")];
      const chart = charts.find((one) => one.data.some((d) => d.meta));
      const data = chart.data.find((one) => one.meta);
      chart.emit("plotly_click", { points: [{ data }] });
      return data.meta; })()""")
    wait_for(tab, f"now.id === '{trial}' && now.drawn")
    assert tab.console_messages() == []


def test_videos_beside_the_page_are_loaded_on_demand(tmp_path, browser, monkeypatch):
    monkeypatch.setattr("bluekoi.report.media.MAX_CLIP_BYTES", 0)
    found = campaign_with_damping_found(exact_campaign())
    write_trial_overlay(found, "T02", tmp_path, tmp_path / "overlays" / "T02.mp4")
    page = write_page(found, tmp_path)
    assert 'id="clip-T02"' not in page.read_text(encoding="utf-8")
    tab = Tab(browser, page)
    assert not tab.evaluate("document.querySelector('video').getAttribute('src')")
    tab.evaluate("location.hash = 'trial-T02'")
    wait_for(tab, "document.querySelector('video').readyState > 1")
    assert tab.evaluate("document.querySelector('video').videoWidth") == 640
    assert tab.console_messages() == []


def test_a_page_of_200_trials_with_videos_opens_in_two_seconds(page, tmp_path, browser):
    film = (page.parent / "overlays" / "T02.mp4").read_bytes()
    many = repeated_trials(campaign_with_damping_found(exact_campaign()), 200)
    (tmp_path / "overlays").mkdir()
    for trial in many.study.trials:
        (tmp_path / "overlays" / f"{trial.trial_id}.mp4").write_bytes(film + bytes(200_000))
    tab = Tab(browser, write_page(many, tmp_path))
    loaded = "performance.getEntriesByType('navigation')[0].loadEventEnd"
    assert 0 < tab.evaluate(loaded) < 2000
    tab.evaluate("location.hash = 'trial-N0199'")
    wait_for(
        tab, "now.id === 'N0199' && now.drawn && document.querySelector('video').readyState > 1"
    )
    assert tab.console_messages() == []


def test_it_can_be_read_on_a_phone(page, browser):
    tab = Tab(browser, page, phone=True)
    assert tab.evaluate("document.documentElement.clientWidth") == 390
    assert tab.evaluate(SMALLEST_FONT_SCRIPT) >= 12
    assert tab.evaluate(OFFSCREEN_ELEMENTS_SCRIPT) == []
    tab.evaluate("location.hash = 'trial-T02'")
    wait_for(tab, "now.id === 'T02' && now.drawn")
    assert tab.evaluate(CUT_CAPTIONS_SCRIPT) == []
    assert tab.evaluate(READOUT_OVERHANG_SCRIPT) <= 1
    assert tab.evaluate(BROKEN_WORDS_JS) == []


def test_the_keyboard_reaches_and_sorts_with_a_ring_around_what_has_the_focus(page, browser):
    tab = Tab(browser, page)
    tab.press("Tab", 9)
    assert "Skip" in tab.evaluate(FOCUSED_ELEMENT_SCRIPT)[1]
    for _ in range(60):
        tab.press("Tab", 9)
        tag, text, table, style, width = tab.evaluate(FOCUSED_ELEMENT_SCRIPT)
        assert style != "none", (tag, text)
        assert width >= 2, (tag, text)
        if tag == "BUTTON" and table == "trial-table":
            break
    assert (tag, table) == ("BUTTON", "trial-table")
    tab.press("Enter", 13, "\r")
    heading = "document.activeElement.closest('th').getAttribute('aria-sort')"
    assert tab.evaluate(heading) == "ascending"
    tab.press("Enter", 13, "\r")
    assert tab.evaluate(heading) == "descending"


def test_on_paper_nothing_is_hidden_or_cut_off(page, browser):
    tab = Tab(browser, page)
    tab.call("Emulation.setEmulatedMedia", media="print")
    assert tab.evaluate("getComputedStyle(document.querySelector('nav')).display") == "none"
    done = tab.call("Page.printToPDF", paperWidth=8.27, paperHeight=11.69)
    pdf = base64.b64decode(done["data"])
    assert pdf.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) >= 4
    assert tab.evaluate("[...document.querySelectorAll('details')].every((part) => part.open)")
    assert tab.console_messages() == []


def test_the_page_of_a_thousand_trials_opens_and_sorts_at_once(tmp_path, browser):
    many = repeated_trials(campaign_with_damping_found(exact_campaign()), 1000)
    page = write_page(many, tmp_path)
    assert page.stat().st_size < 5_000_000
    start = time.monotonic()
    tab = Tab(browser, page)
    assert time.monotonic() - start < 15
    rows = "document.querySelectorAll('#trial-table tbody tr').length"
    assert tab.evaluate(rows) == 1000
    sort = "(() => { const t = performance.now(); document.querySelectorAll(" \
        "'#trial-table thead button')[5].click(); return performance.now() - t; })()"  # fmt: skip
    assert tab.evaluate(sort) < 2000
    assert tab.console_messages() == []
