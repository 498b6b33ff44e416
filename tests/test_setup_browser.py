"""`bluekoi setup` in a real browser: `make test-long`, where chromium is installed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import time

import cv2
import numpy as np
import pytest

from bluekoi.stages.demo import write_demo_study
from bluekoi.study import load_study
from bluekoi.synthetic.study_rendering import render_trial
from bluekoi.synthetic.synthetic_study_design import demo_design
from browser import Browser, Tab

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed"),
]
TRIALS = ("T01", "T04")
CORNER_CLICKS = {
    "(0,0)": (258, 938),
    "(L,0)": (1605, 943),
    "(L,W)": (1620, 119),
    "(0,W)": (253, 97),
}
ROBOT = {"body_length_m": 0.331, "head_length_m": 0.12, "head_span_m": 0.069, "mass_kg": 0.68,
         "hinge_to_com_m": 0.04, "tail_length_m": 0.066, "yaw_inertia_kg_m2": 0.0095}  # fmt: skip
TYPED_LISTS = (
    ("image_size_px", "1920 x 1080", "[1920, 1080]"),
    ("distortion", "\N{MINUS SIGN}0.03, 0.01, 0, 0", "[-0.03, 0.01, 0, 0]"),
    ("matrix", "9 0 4, 0 9 2, 0 0 1", "[[9, 0, 4], [0, 9, 2], [0, 0, 1]]"),
)
"""Keys, what is typed without brackets, and the list that it stands for."""
TYPE_SCRIPT = """((id, text) => { const e = document.getElementById(id); e.focus(); e.value = text;
  for (const kind of ["input", "change"]) e.dispatchEvent(new Event(kind, {bubbles: true})); })"""
PLACE_SCRIPT = """((label) => { const e = [...document.querySelectorAll(".handle")]
  .find((one) => one.dataset.label === label && one.getClientRects().length);
  e.scrollIntoView({block: "center"}); const f = e.closest(".frame"), r = e.getBoundingClientRect();
  const q = f.getBoundingClientRect();
  return [r.left + r.width / 2, r.top + r.height / 2, q.left, q.top,
    q.width / f.querySelector("img").naturalWidth]; })"""
PASTE_SCRIPT = """((text) => {
  const i = document.querySelector("input[data-row='0'][data-column=power_pct]");
  i.focus(); const d = new DataTransfer(); d.setData("text/plain", text);
  i.dispatchEvent(new ClipboardEvent("paste", {clipboardData: d, bubbles: true, cancelable: true}));
})"""


class Page:
    """The page of a study folder, open in a tab."""

    def __init__(self, folder, profile, *, phone: bool = False) -> None:
        words = [sys.executable, "-P", "-m", "bluekoi", "setup", str(folder), "--no-browser"]
        self.server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, cwd=profile)
        address = re.search(r"http\S+", self.server.stdout.readline())[0]
        self.browser = Browser(shutil.which("chromium"), profile / "profile", 1300)
        self.tab = Tab(self.browser, address, phone=phone)
        self.until("document.body.dataset.ready")
        self.until("document.querySelector('#pool-frame img').naturalWidth > 0")

    def until(self, condition: str, patience_s: float = 90.0) -> None:
        end = time.monotonic() + patience_s
        while not self.tab.evaluate(f"Boolean({condition})"):
            assert time.monotonic() < end, condition
            time.sleep(0.1)

    def type(self, name: str, text: object) -> None:
        self.tab.evaluate(f"{TYPE_SCRIPT}({json.dumps(name)}, {json.dumps(str(text))})")

    def step(self, name: str) -> None:
        self.tab.evaluate(f"location.hash = '{name}'")
        self.until(f"!document.getElementById('{name}').hidden")

    def text(self, name: str) -> str:
        return self.tab.evaluate(f"document.getElementById({json.dumps(name)}).textContent")

    def stored(self, what: str) -> str:
        return self.tab.evaluate(f"import('./page/store.js').then((m) => {what})")

    def click(self, name: str) -> None:
        self.tab.evaluate(f"document.getElementById({json.dumps(name)}).click()")

    def drag(self, label: str, to_px: tuple[float, float]) -> None:
        x, y, left, top, scale = self.tab.evaluate(f"{PLACE_SCRIPT}({json.dumps(label)})")
        end = (left + (to_px[0] + 0.5) * scale, top + (to_px[1] + 0.5) * scale)
        for kind, (u, v) in (("mousePressed", (x, y)), ("mouseMoved", end), ("mouseReleased", end)):
            self.tab.call("Input.dispatchMouseEvent", type=kind, x=u, y=v, button="left",
                          buttons=1, clickCount=1)  # fmt: skip

    def fitted(self) -> None:
        time.sleep(0.5)
        self.until("!document.getElementById('pool-fit').textContent.startsWith('Fitting')")

    def close(self) -> None:
        self.browser.close()
        self.server.terminate()
        assert self.server.wait(20) == 0


@pytest.fixture(scope="module")
def videos(tmp_path_factory):
    """The demo's study with two rendered trials."""
    demo = tmp_path_factory.mktemp("made") / "demo"
    write_demo_study(demo)
    for name in TRIALS:
        render_trial(demo_design(), name, demo, demo.with_name("truth"), threads=2)
    return demo


def corners_count_once_all_four_are_placed(page: Page) -> None:
    for label, at in CORNER_CLICKS.items():
        assert "pool_corners_px" not in page.stored("Object.keys(m.store.values).join()")
        page.drag(f"Corner {label}", at)
    page.fitted()


def lists_without_brackets_are_understood(page: Page) -> None:
    page.step("camera")
    assert "No calibration" in page.text("camera-state")
    for key, typed, kept in TYPED_LISTS:
        page.type(f"camera.{key}", typed)
        page.until(f"document.getElementById('camera.{key}').value === '{kept}'")
        page.type(f"camera.{key}", "")


def wrong_sign_is_named_and_mended(page: Page) -> None:
    for angles, seen in (("0 -30", "with head_angle_deg 30 the robot is found"), ("0 30", "")):
        page.step("trials")
        cells = "\n".join(f"50\t{angle}" for angle in angles.split())
        page.tab.evaluate(f"{PASTE_SCRIPT}({json.dumps(cells)})")
        page.until("!document.querySelector('#trials-table [aria-invalid=true]')")
        page.step("preview")
        page.click("preview-all")
        page.until(
            "document.getElementById('preview-said').textContent.startsWith('The robot')", 200
        )
        assert seen in page.text("preview-list")
        page.step("run")
        lost = "T04: robot found in 0 of 20 frames" in page.text("run-findings")
        assert lost == bool(seen)


def test_from_a_folder_of_videos_to_a_saved_study(videos, tmp_path):
    folder = tmp_path / "new"
    for part in ("videos", "motor"):
        shutil.copytree(videos / part, folder / part)
    page = Page(folder, tmp_path)
    try:
        for name, value in (("length_m", 2.6), ("width_m", 1.6), ("depth_m", "0,3")):
            page.type(f"pool.{name}", value)
        page.until("document.getElementById('pool.depth_m-error').textContent.includes('number')")
        page.type("pool.depth_m", 0.3)
        corners_count_once_all_four_are_placed(page)
        page.click("pool-use")
        page.fitted()
        assert "confirm these corners" in page.text("pool-fit")
        lists_without_brackets_are_understood(page)
        page.step("robot")
        for name, value in ROBOT.items():
            page.type(f"robot.{name}", value)
        wrong_sign_is_named_and_mended(page)
        assert "2 of 2 videos" in page.text("preview-said")
        page.step("robot")
        page.click("robot-place")
        page.until("/^Nose to caudal base: 1[67][0-9] px/.test("
                   "document.getElementById('robot-said').textContent)")  # fmt: skip
        page.click("save")
        page.until("document.getElementById('saved').textContent.includes('trials.csv saved')")
        page.step("run")
        page.until(
            "document.getElementById('run-findings').textContent.includes('Nothing is wrong')"
        )
        assert page.tab.console_messages() == []
    finally:
        page.close()
    found, made = load_study(folder), load_study(videos)
    corners = [np.array(one.setup.camera.pool_corners_px) for one in (found, made)]
    assert np.abs(corners[0] - corners[1]).max() < 1.5
    assert [trial.head_angle_deg for trial in found.trials] == [0, 30]
    assert found.setup.robot.mass_kg == 0.68
    assert "# Mass of the robot" in (folder / "study.yaml").read_text()


def test_at_390_px_nothing_is_wider_than_the_page_and_corners_move_by_keys(videos, tmp_path):
    page = Page(videos, tmp_path, phone=True)
    wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    try:
        before = json.loads(page.tab.evaluate("import('./page/store.js').then((m) => "
                            "m.store.values['camera.pool_corners_px'])"))  # fmt: skip
        page.tab.evaluate("[...document.querySelectorAll('.handle')][0].focus()")
        page.tab.press("ArrowRight", 39)
        page.tab.press("ArrowUp", 38)
        after = json.loads(page.tab.evaluate("import('./page/store.js').then((m) => "
                           "m.store.values['camera.pool_corners_px'])"))  # fmt: skip
        assert np.subtract(after, before)[0] == pytest.approx([1, -1], abs=0.02)
        assert np.abs(np.subtract(after, before)[1:]).max() < 0.01
        drawn = "document.querySelector('.frame > svg polyline').getAttribute('points')"
        magnified = "document.querySelector('.magnifier svg polyline').getAttribute('points')"
        assert page.tab.evaluate(magnified) == page.tab.evaluate(drawn)
        page.until("document.querySelector('#robot-drawing svg [data-key]')")
        for step in ("pool", "camera", "robot", "trials", "preview", "run"):
            page.step(step)
            time.sleep(0.5)
            assert page.tab.evaluate(wide) <= 0, step
    finally:
        page.close()
    assert not (videos / ".backup").exists()


def test_why_nothing_is_found_stands_beside_the_video(tmp_path):
    from bluekoi.footage import encode_h264

    frame = np.full((360, 640, 3), 60, np.uint8)
    cv2.rectangle(frame, (60, 60), (580, 300), (170, 170, 170), -1)
    folder = tmp_path / "empty"
    folder.mkdir()
    encode_h264(folder / "p50_phi0.mp4", iter([frame] * 24), fps=30, size=(640, 360))
    (folder / "x;y.mp4").write_bytes(b"")
    page = Page(folder, tmp_path)
    try:
        assert page.text("notes").startswith("x;y.mp4 is left out")
        for name, value in (("length_m", 2.6), ("width_m", 1.2), ("depth_m", 0.3)):
            page.type(f"pool.{name}", value)
        for label, at in zip(
            CORNER_CLICKS, ((60, 300), (580, 300), (580, 60), (60, 60)), strict=True
        ):
            page.drag(f"Corner {label}", at)
        page.step("robot")
        page.until("document.getElementById('robot-said').textContent.startsWith("
                   "'The outline needs: Body length, ')")  # fmt: skip
        for name, value in ROBOT.items():
            page.type(f"robot.{name}", value)
        page.step("trials")
        page.until("!document.querySelector('#trials-table [aria-invalid=true]')")
        page.step("preview")
        page.click("preview-all")
        page.until(
            "document.getElementById('preview-said').textContent.startsWith('The robot')", 200
        )
        assert "nothing differs from the background" in page.text("preview-list")
    finally:
        page.close()
