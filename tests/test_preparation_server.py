"""The server of `bluekoi setup`: whom it answers, what it answers, what it writes."""

from __future__ import annotations

import http.client
import json
import subprocess
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import cv2
import numpy as np
import pytest

from bluekoi.cli.run import run
from bluekoi.cli.setup import bluekoi_run_arguments
from bluekoi.data import Keypoints
from bluekoi.footage import encode_h264
from bluekoi.preparation.draft import Draft
from bluekoi.preparation.draft_check import study_from_draft
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


@contextmanager
def serving(folder):
    """A server at work on a study folder."""
    words = ["python", "-c", "print('[1/2] tracks'); print('[2/2] report')"]
    made = SetupServer(folder, folder / "out", words)

    def serve():
        with suppress(OSError):  # it is closed by another thread
            made.serve()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield made
    finally:
        made.close()
        thread.join(10)


@pytest.fixture(scope="module")
def server(study_folder):
    with serving(study_folder) as made:
        yield made


@pytest.fixture
def server_of_new_study(tmp_path):
    with serving(tmp_path) as made:
        yield made


def send_request(server, name, content=None, *, headers=None, path=None):
    body = None if content is None else json.dumps(content)
    status, kind, data = send_body(server, name, body, headers=headers, path=path)
    return status, json.loads(data) if kind.startswith("application/json") else data


def send_body(server, name, body, *, headers=None, path=None):
    """Status, content type and body of an answer, which no browser may take for another type."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    given = {"Content-Type": "application/json"} if body else {}
    connection.request(
        "GET" if body is None else "POST", path or f"/{server.token}/{name}", body,
        {"Host": f"127.0.0.1:{server.port}", **given, **(headers or {})},
    )  # fmt: skip
    answer = connection.getresponse()
    data = answer.read()
    connection.close()
    if answer.status >= 400:
        assert answer.getheader("X-Content-Type-Options") == "nosniff"
        assert answer.getheader("Cache-Control") == "no-store"
    return answer.status, answer.getheader("Content-Type", ""), data


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
    assert server.page_url.startswith(f"http://127.0.0.1:{server.port}/")
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

    monkeypatch.setattr("bluekoi.preparation.preview.keypoint_source_module", lambda name: Detector)
    for angle, said in (("20", "with head_angle_deg -20 the robot is found"),
                        ("30", "does not fit the stated lengths"), ("-20", None)):  # fmt: skip
        row = {"trial_id": "S", "source": "p50_phi20.mp4", "power_pct": "50",
               "head_angle_deg": angle, "head_length_m": "0.12"}  # fmt: skip
        study = study_from_draft(Draft(DRAFT_VALUES, [row]), study_folder)
        remarks = preview_trial(study, "S").remarks
        assert (said in remarks[0]) if said else remarks == ()


def test_a_run_from_the_page_is_that_of_the_command(tmp_path):
    words = bluekoi_run_arguments(tmp_path / "lab", tmp_path / "out")
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


def test_of_saves_at_once_one_is_accepted_and_the_others_are_conflicts(server_of_new_study):
    server, folder = server_of_new_study, server_of_new_study.folder
    rows = [{"trial_id": "A", "power_pct": "1"}]
    first = {"values": DRAFT_VALUES, "rows": rows}
    revision = send_request(server, "save", first)[1]["draft"]["revision"]
    begin, answers = threading.Barrier(6), {}

    def save(number):
        draft = {"values": {**DRAFT_VALUES, "pool.length_m": str(number)},
                 "rows": [{**rows[0], "power_pct": str(number)}], "revision": revision}  # fmt: skip
        begin.wait()
        answers[number] = send_request(server, "save", draft)

    threads = [threading.Thread(target=save, args=(number,)) for number in range(2, 8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (kept,) = (number for number, (status, _) in answers.items() if status == 200)
    assert all("changed by another program" in answer["error"]
               for number, (_, answer) in answers.items() if number != kept)  # fmt: skip
    assert f"length_m: {kept}\n" in (folder / "study.yaml").read_text()
    assert f"A,,{kept}," in (folder / "trials.csv").read_text()
    assert len(list((folder / ".backup").iterdir())) == 2


def test_a_save_that_lacks_its_parts_is_refused_and_names_them(server_of_new_study):
    server, folder = server_of_new_study, server_of_new_study.folder
    whole = {"values": DRAFT_VALUES, "rows": []}
    wrong = (
        ({}, "values: found nothing"),
        ({"rows": []}, "values: found nothing"),
        ({"values": {}}, "rows: found nothing"),
        ({**whole, "values": {"pool.depth": "1"}}, "pool.depth: found an unknown key"),
        ({**whole, "values": {"pool.length_m": None}}, "pool.length_m: found nothing"),
        ({**whole, "rows": [{"power": "1"}]}, "power: found an unknown column"),
    )
    for content, said in wrong:
        status, answer = send_request(server, "save", content)
        assert status == 400
        assert said in answer["error"]
        assert not (folder / "study.yaml").exists()
    assert send_request(server, "save", whole)[0] == 200
    before = (folder / "study.yaml").read_text()
    for revision in ({}, {"revision": ""}, {"revision": None}):
        status, answer = send_request(server, "save", {"values": {}, "rows": [], **revision})
        assert status == 400
        assert "does not say which revision" in answer["error"]
    assert (folder / "study.yaml").read_text() == before


def test_a_folder_that_cannot_be_written_is_named(server_of_new_study):
    server, folder = server_of_new_study, server_of_new_study.folder
    saved = send_request(server, "save", {"values": DRAFT_VALUES, "rows": []})[1]["draft"]
    (folder / ".backup").write_text("a file", encoding="utf-8")
    draft = {"values": {}, "rows": [], "revision": saved["revision"]}
    status, answer = send_request(server, "save", draft)
    assert status == 400
    assert ".backup: found 'File exists'" in answer["error"]


@pytest.mark.parametrize("name", ["check", "save", "corners", "outline", "recording_properties",
                                  "preview", "calibrate"])  # fmt: skip
@pytest.mark.parametrize("body", ["[]", "{", "nonsense", "[" * 100_000, '{"a":' * 100_000])
def test_a_broken_request_ends_in_words(server, name, body):
    status, _, data = send_body(server, name, body)
    assert status == 400
    assert "request: found" in json.loads(data)["error"]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("recording_properties", {"rows": [1]}, "rows[0]: found 1; expected"),
        ("recording_properties", {"rows": [{"source": 5}]}, "rows[0], source: found 5; expected"),
        ("recording_properties", {}, "rows: found nothing; expected"),
        ("corners", {"values": 5, "source": "p50_phi20.mp4", "share": 0}, "values: found 5"),
        ("corners", {"values": {}, "source": "a.mp4", "share": float("nan")}, "share: found nan"),
        ("corners", {"values": {"pool.length_m": "[" * 3000, "pool.width_m": "2024-13-45"},
                     "source": "p50_phi20.mp4", "share": 0}, "pool, length_m: found"),
        ("check", {"values": {"bodyparts": "{a: 1, a: 2}"}, "rows": 1}, "rows: found 1"),
    ],
)  # fmt: skip
def test_a_value_of_the_wrong_kind_is_named(server, name, content, said):
    status, answer = send_request(server, name, content)
    assert status == 400
    assert said in answer["error"]


def test_a_name_too_long_for_a_file_is_an_error_of_its_row(server):
    rows = [{"source": f"{'a' * 400}.mp4", "motor_log": "b" * 400}, {"source": "p50_phi20.mp4"}]
    status, answer = send_request(server, "recording_properties", {"rows": rows})
    assert status == 200
    assert "expected a video" in answer["rows"][0]["error"]
    assert answer["rows"][1]["fps"] == 30


def test_a_draft_of_more_than_a_hundred_kilobytes_is_read(server):
    content = {"values": {"pool.length_m": "2" + " " * 200_000}, "rows": []}
    assert send_request(server, "check", content)[0] == 200


@pytest.mark.parametrize(
    "query",
    ["share=abc", "share=nan", "share=1e999", "first=abc", "first=nan", f"source={'a' * 400}",
     "source=%3Cscript%3E.mp4"],
)  # fmt: skip
def test_errors_of_a_frame_are_plain_text(server, query):
    source = "" if "source" in query else "source=p50_phi20.mp4&"
    status, kind, text = send_body(server, f"frame.jpg?{source}{query}", None)
    assert (status, kind) == (400, "text/plain; charset=UTF-8")
    assert b"expected" in text


def test_a_video_that_trials_csv_cannot_name_is_left_out_and_the_page_says_so(server_of_new_study):
    for name in ("x;y.mp4", "z.mp4"):
        (server_of_new_study.folder / name).write_bytes(b"")
    state = send_request(server_of_new_study, "state")[1]
    assert (
        state["files"]["videos"] == [row["source"] for row in state["draft"]["rows"]] == ["z.mp4"]
    )
    assert state["new_rows"] == []
    assert state["notes"][0].startswith("x;y.mp4 is left out")


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
