"""The server of `bluekoi setup`: whom it answers, what it answers, what it writes."""

from __future__ import annotations

import http.client
import json
import subprocess
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from bluekoi.cli.run import run
from bluekoi.cli.setup import run_command
from bluekoi.data import Keypoints
from bluekoi.footage import encode_h264
from bluekoi.preparation.draft import Draft
from bluekoi.preparation.draft_check import draft_study
from bluekoi.preparation.prefill import study_files
from bluekoi.preparation.preview import preview_trial
from bluekoi.preparation.server import SetupServer

ROBOT = {"mass_kg": "0.68", "yaw_inertia_kg_m2": "0.0095", "body_length_m": "0.331",
         "head_length_m": "0.12", "head_span_m": "0.069", "hinge_to_com_m": "0.04",
         "tail_length_m": "0.066"}  # fmt: skip
CORNERS = [[60.0, 300.0], [580.0, 300.0], [580.0, 60.0], [60.0, 60.0]]
DRAFT_VALUES = {"pool.length_m": "2.6", "pool.width_m": "1.2", "pool.depth_m": "0.3",
          "camera.pool_corners_px": json.dumps(CORNERS),
          **{f"robot.{key}": value for key, value in ROBOT.items()}}  # fmt: skip


def pool_frames(count: int = 24):
    """A bright pool on a dark floor, without a robot."""
    frame = np.full((360, 640, 3), 60, np.uint8)
    cv2.rectangle(frame, (60, 60), (580, 300), (170, 170, 170), -1)
    return [frame] * count


@pytest.fixture(scope="module")
def study_folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("study")
    encode_h264(made / "p50_phi20.mp4", iter(pool_frames()), fps=30, size=(640, 360))
    return made


@pytest.fixture(scope="module")
def server(study_folder):
    words = ["python", "-c", "print('[1/2] tracks'); print('[2/2] report')"]
    made = SetupServer(study_folder, study_folder / "out", words)
    thread = threading.Thread(target=made.serve, daemon=True)
    thread.start()
    yield made
    made.close()
    thread.join(10)


def send_request(server, name, content=None, *, headers=None, path=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    body = None if content is None else json.dumps(content)
    given = {"Content-Type": "application/json"} if body else {}
    connection.request(
        "GET" if body is None else "POST", path or f"/{server.token}/{name}", body,
        {"Host": f"127.0.0.1:{server.port}", **given, **(headers or {})},
    )  # fmt: skip
    answer = connection.getresponse()
    data = answer.read()
    connection.close()
    kind = answer.getheader("Content-Type", "")
    return answer.status, json.loads(data) if kind.startswith("application/json") else data


@pytest.mark.parametrize(
    ("headers", "path", "status"),
    [
        ({"Host": "example.org"}, None, 403),
        ({"Host": "127.0.0.1"}, None, 403),
        ({"Origin": "http://example.org"}, None, 403),
        ({"Origin": "null"}, None, 403),
        ({"Sec-Fetch-Site": "cross-site"}, None, 403),
        ({}, "/state", 404),
        ({}, "/wrong-token/state", 404),
        ({}, "/", 404),
    ],
)
def test_who_has_no_business_here_is_refused(server, headers, path, status):
    assert send_request(server, "state", headers=headers, path=path)[0] == status


def test_only_this_machine_is_served_and_the_token_is_long(server):
    assert server.address.startswith(f"http://127.0.0.1:{server.port}/")
    assert len(server.token) >= 32


def test_own_pages_are_served_and_no_file_outside_of_them(server):
    status, page = send_request(server, "")
    assert status == 200
    assert b"page/main.js" in page
    assert b"http" not in page.replace(b"http://www.w3.org", b"")
    for name in ("page/..%2fserver.py", "page/%2e%2e/server.py", "results/..%2fstudy.yaml"):
        assert send_request(server, name)[0] in (403, 404)


def test_the_state_of_a_folder_of_videos(server, study_folder):
    status, state = send_request(server, "state")
    assert status == 200
    assert state["files"]["videos"] == list(study_files(study_folder).videos) == ["p50_phi20.mp4"]
    assert state["draft"]["rows"][0]["head_angle_deg"] == "20"
    assert {"pool.length_m", "robot.mass_kg"} <= {one["key"] for one in state["findings"]}


def test_a_frame_and_the_edges_in_it(server):
    status, picture = send_request(server, "frame.jpg?source=p50_phi20.mp4&share=0.5")
    assert status == 200
    assert cv2.imdecode(np.frombuffer(picture, np.uint8), 0).shape == (360, 640)
    moved = [[u + 2, v - 1.5] for u, v in CORNERS]
    values = DRAFT_VALUES | {"camera.pool_corners_px": json.dumps(moved)}
    status, found = send_request(
        server, "corners", {"values": values, "source": "p50_phi20.mp4", "share": 0.5}
    )
    assert status == 200
    assert np.abs(np.array(found["suggested_px"]) - CORNERS).max() < 1.0
    assert found["sentences"]


@pytest.mark.parametrize("source", ["../secret.mp4", "gone.mp4", "", "/etc/passwd"])
def test_what_is_no_video_is_refused_in_words(server, source):
    status, text = send_request(server, f"frame.jpg?source={source}&share=0")
    assert status == 400
    assert b"expected" in text


def test_the_outline_is_to_scale(server):
    place = {"x_px": 320, "y_px": 180, "toward_x_px": 420, "toward_y_px": 180,
             "head_angle_deg": 30, "head_length_m": 0}  # fmt: skip
    status, found = send_request(server, "outline", {"values": DRAFT_VALUES, "place": place})
    assert status == 200
    (nose, hinge), (_, base) = np.array(found["head"]), np.array(found["core"])
    scale = 520 / 2.6
    assert hinge[0] - base[0] == pytest.approx(scale * (0.331 - 0.12), rel=0.03)
    assert nose[1] > hinge[1]  # a positive head angle turns the head clockwise seen from above
    assert np.degrees(np.arctan2(*(nose - hinge)[::-1])) == pytest.approx(30, abs=1)


def test_the_preview_says_why_nothing_is_found(server):
    row = {"trial_id": "A", "source": "p50_phi20.mp4", "power_pct": "50", "head_angle_deg": "0",
           "head_length_m": "0.12"}  # fmt: skip
    status, _ = send_request(
        server, "preview", {"values": DRAFT_VALUES, "rows": [row], "trial_id": "A"}
    )
    assert status == 200
    job = poll_job(server, "job?name=preview%20A", lambda job: job["state"] in ("done", "failed"))
    assert job["state"] == "done", job
    assert job["result"]["found"] == 0
    assert "nothing differs from the background" in job["result"]["remarks"][0]


def test_a_preview_that_is_refused_names_the_row_of_the_table(server):
    row = {"trial_id": "A", "source": "p50_phi20.mp4", "power_pct": "750", "head_angle_deg": "0",
           "head_length_m": "0.12"}  # fmt: skip
    rows = [{**row, "trial_id": name} for name in ("B", "C", "A")]
    status, answer = send_request(
        server, "preview", {"values": DRAFT_VALUES, "rows": rows, "trial_id": "A"}
    )
    assert status != 200
    assert "row 4 (A), power_pct: found '750'" in answer["error"]


def test_the_preview_names_a_head_angle_of_the_wrong_sign(study_folder, monkeypatch):
    class Detector:
        @staticmethod
        def detect_keypoints(frames, setup, trial):
            n, sure = len(list(frames())), 1.0 if trial.head_angle_deg == -20 else 0.0
            return Keypoints(np.arange(n) / 30, ("head_tip",), np.full((n, 1, 2), 100.0),
                             np.full((n, 1), sure), np.zeros((n, 1, 2, 2)))  # fmt: skip

    monkeypatch.setattr("bluekoi.preparation.preview.source_module", lambda name: Detector)
    for angle, said in (("20", "with head_angle_deg -20 the robot is found"),
                        ("30", "does not fit the stated lengths"), ("-20", None)):  # fmt: skip
        row = {"trial_id": "S", "source": "p50_phi20.mp4", "power_pct": "50",
               "head_angle_deg": angle, "head_length_m": "0.12"}  # fmt: skip
        study = draft_study(Draft(DRAFT_VALUES, [row]), study_folder)
        remarks = preview_trial(study, "S").remarks
        assert (said in remarks[0]) if said else remarks == ()


def test_a_run_from_the_page_is_that_of_the_command(tmp_path):
    words = run_command(tmp_path / "lab", tmp_path / "out")
    assert words[1:5] == ["-P", "-m", "bluekoi", "run"]
    given = run.make_context("run", words[5:]).params
    assert (given["study"], given["results"]) == (str(tmp_path / "lab"), tmp_path / "out")
    missing = subprocess.run(words, check=False, capture_output=True, text=True, cwd=tmp_path)
    assert missing.returncode == 1
    assert "no such folder" in missing.stderr


def test_a_lens_taken_from_a_file(server, study_folder):
    (study_folder / "camera.yaml").write_text(
        "camera:\n  model: fisheye\n  image_size_px: [640, 360]\n"
        "  matrix: [[400, 0, 320], [0, 400, 180], [0, 0, 1]]\n  distortion: [0.1, 0, 0, 0]\n",
        encoding="utf-8",
    )
    send_request(server, "calibrate", {"files": "camera.yaml", "pattern": "9x6", "square_mm": 25})
    job = poll_job(server, "job?name=calibration", lambda job: job["state"] in ("done", "failed"))
    assert job["result"]["values"]["camera.model"] == "fisheye"
    send_request(server, "calibrate", {"files": "board/*.jpg", "pattern": "9x6", "square_mm": 25})
    job = poll_job(server, "job?name=calibration", lambda job: job["state"] in ("done", "failed"))
    assert "no such file" in job["error"]


def test_saved_checked_run_and_followed(server, study_folder):
    row = {"trial_id": "A", "source": "p50_phi20.mp4", "power_pct": "50", "head_angle_deg": "0"}
    revision = send_request(server, "state")[1]["draft"]["revision"]
    draft = {"values": DRAFT_VALUES, "rows": [row], "revision": revision}
    found = send_request(server, "check", {**draft, "files": True})[1]["findings"]
    assert [(one["row"], one["column"]) for one in found] == [(0, "head_length_m")]
    assert not (study_folder / "study.yaml").exists()
    draft["rows"] = [row | {"head_length_m": "0.12"}]
    status, saved = send_request(server, "save", draft)
    assert (status, saved["done"], saved["findings"]) == (
        200, ["study.yaml saved", "trials.csv saved"], [],
    )  # fmt: skip
    (study_folder / "trials.csv").write_text("", encoding="utf-8")
    status, refused = send_request(
        server, "save", {**draft, "revision": saved["draft"]["revision"]}
    )
    assert status == 400
    assert "changed by another program" in refused["error"]
    send_request(server, "start", {})
    state = poll_job(server, "run", lambda state: not state["running"])
    assert (state["exit_code"], state["lines"][-1]) == (0, "[2/2] report")
    assert not state["report"]


@pytest.mark.parametrize("body", ["[]", "{", "nonsense"])
def test_a_broken_request_ends_in_words(server, body):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    connection.request("POST", f"/{server.token}/check", body,
                       {"Content-Type": "application/json"})  # fmt: skip
    assert connection.getresponse().status == 400
    connection.close()


def poll_job(server, name, true, patience_s: float = 100.0):
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        state = send_request(server, name)[1]
        if true(state):
            return state
        time.sleep(0.1)
    raise AssertionError(f"{name} after {patience_s} s: {state}")


def test_the_page_loads_nothing_from_elsewhere():
    page = Path(__file__).parents[1] / "pipeline/bluekoi/preparation/page"
    for path in page.iterdir():
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
        assert "http://" not in text, path.name
        assert "https://" not in text, path.name
