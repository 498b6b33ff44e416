"""The server of `bluekoi setup`: on the local machine only, a random token in the address."""

from __future__ import annotations

import hmac
import json
import re
import secrets
import threading
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import bottle
import waitress

from ..errors import InputError
from . import page_request_handlers as answers
from .draft_check import draft_findings, study_from_draft
from .draft_saving import save_draft
from .frame_images import encode_jpeg, preview_as_json
from .jobs import AnalysisProcess, BackgroundJobs
from .request_values import (
    draft_from_request,
    finite_number,
    parse_request,
    rows_from_request,
    validated_text_mapping,
)

PAGE_FOLDER = Path(__file__).parent / "page"
HOST = "127.0.0.1"
MAX_REQUEST_BYTES = 20_000_000
SERVER_THREADS = 6
CONTENT_SECURITY_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; form-action 'none'; base-uri 'none'"
)
SECURITY_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
PLAIN_TEXT_CONTENT_TYPE = "text/plain; charset=UTF-8"
BAD_REQUEST_EXCEPTIONS = (KeyError, TypeError, ValueError)
"""Errors of an answer by which the request was wrong in a way that no check names."""


class SetupServer:
    """The page of one study folder. Nothing is answered without the token, to another host name, or
    to a page of another origin.

    run_words: the command that runs the study; results: its folder.
    """

    def __init__(
        self, folder: Path, results: Path, run_words: Sequence[str], *, port: int = 0
    ) -> None:
        self.folder, self.results = folder.resolve(), results.resolve()
        self.token = secrets.token_urlsafe(24)
        self._saving = threading.Lock()
        self.jobs, self.run = BackgroundJobs(), AnalysisProcess(run_words, results / "report.html")
        self._server = waitress.create_server(
            self._application(), host=HOST, port=port, threads=SERVER_THREADS,
            max_request_body_size=MAX_REQUEST_BYTES, ident=None,
        )  # fmt: skip
        self.port = int(self._server.effective_port)

    @property
    def page_url(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def serve(self) -> None:
        """Answer until `close`, or until interrupted."""
        self._server.run()

    def close(self) -> None:
        """End jobs and run, each in order.

        The threads of the server end first: one that still answers would wake up the closed server
        by a byte, in whatever file has the number of its pipe by then.
        """
        self.run.stop()
        self.jobs.close()
        self._server.task_dispatcher.shutdown()
        self._server.close()

    def _application(self) -> bottle.Bottle:
        app = bottle.Bottle()
        app.add_hook("before_request", self._check_access)
        app.default_error_handler = _text_error_response
        root = f"/{self.token}/"
        app.get(root, callback=lambda: self._static_page_file("index.html"))
        app.get(f"{root}page/<name>", callback=self._static_page_file)
        app.get(f"{root}frame.jpg", callback=self._frame_jpeg)
        app.get(f"{root}results/<path:path>", callback=self._result_file)
        questions = {"state": self._page_state, "run": self.run.state, "job": self._job_state}
        orders = {
            "check": self._check_draft,
            "save": self._save_draft,
            "corners": self._compare_corners,
            "outline": self._robot_outline,
            "recording_properties": self._recording_properties,
            "preview": self._start_preview,
            "calibrate": self._start_calibration,
            "start": self._start_run,
            "stop": self._stop_run,
        }
        for name, work in questions.items():
            app.get(f"{root}{name}", callback=partial(_json_response, work))
        for name, work in orders.items():
            app.post(f"{root}{name}", callback=partial(_json_response, work))
        return app

    def _check_access(self) -> None:
        """Refuse a request without the token, for another host, or from another origin."""
        request = bottle.request
        hosts = {f"{name}:{self.port}" for name in (HOST, "localhost")}
        origin = request.get_header("Origin")
        token = request.path.split("/")[1]
        if request.get_header("Host") not in hosts:
            bottle.abort(403, "Open the page at the address that the terminal shows.")
        if origin is not None and origin not in {f"http://{host}" for host in hosts}:
            bottle.abort(403, "A request of another page is refused.")
        if request.get_header("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
            bottle.abort(403, "A request of another page is refused.")
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            bottle.abort(404, "Open the page at the address that the terminal shows.")
        _set_security_headers()

    def _static_page_file(self, name: str) -> Any:
        found = bottle.static_file(name, root=str(PAGE_FOLDER))
        found.set_header("Content-Security-Policy", CONTENT_SECURITY_POLICY)
        found.set_header("Cache-Control", "no-store")
        return found

    def _result_file(self, path: str) -> Any:
        return bottle.static_file(path, root=str(self.results))

    def _frame_jpeg(self) -> Any:
        query = bottle.request.query
        try:
            time_s, grey = answers.source_frame(
                self.folder, query.getunicode("source", ""),
                finite_number(query.get("share", "0.5"), "share"), query.get("fps", ""),
                finite_number(query["first"], "first") if "first" in query else None,
            )  # fmt: skip
        except (InputError, *BAD_REQUEST_EXCEPTIONS) as error:
            bottle.response.status = 400
            bottle.response.content_type = PLAIN_TEXT_CONTENT_TYPE
            return _bad_request_text(error)
        bottle.response.content_type = "image/jpeg"
        bottle.response.set_header("X-Time", f"{time_s:.3f}")
        return encode_jpeg(grey)

    def _page_state(self) -> dict[str, Any]:
        shown = answers.page_state(self.folder)
        return {**shown, "results": str(self.results), "run": self.run.state()}

    def _check_draft(self) -> dict[str, Any]:
        content = _request_json()
        draft = draft_from_request(content)
        found = draft_findings(draft, self.folder, files=bool(content.get("files")))
        return {"findings": [asdict(finding) for finding in found]}

    def _save_draft(self) -> dict[str, Any]:
        wanted = draft_from_request(_request_json())
        with self._saving:
            draft, done = save_draft(wanted, self.folder)
        found = draft_findings(draft, self.folder)
        return {"draft": answers.draft_as_json(draft), "done": done,
                "findings": [asdict(finding) for finding in found]}  # fmt: skip

    def _compare_corners(self) -> dict[str, Any]:
        content = _request_json()
        values = validated_text_mapping(content.get("values"), "values")
        _, grey = answers.source_frame(
            self.folder, str(content["source"]), finite_number(content.get("share"), "share"),
            str(content.get("fps", "")),
        )  # fmt: skip
        return answers.corners_compared_with_pool_edges(values, grey)

    def _robot_outline(self) -> dict[str, Any]:
        content = _request_json()
        values = validated_text_mapping(content.get("values"), "values")
        return answers.robot_outline_on_frame(values, content["place"])

    def _recording_properties(self) -> dict[str, Any]:
        rows = rows_from_request(_request_json())
        return {"rows": answers.recording_properties(self.folder, rows)}

    def _start_preview(self) -> dict[str, Any]:
        """Begin the preview of one row; the other rows need not be complete."""
        content = _request_json()
        draft = draft_from_request(content)
        name = str(content["trial_id"])
        rows = {n: row for n, row in enumerate(draft.rows, 2) if row.get("trial_id") == name}
        number = next(iter(rows), 2)
        try:
            study = study_from_draft(replace(draft, rows=list(rows.values())), self.folder)
        except InputError as error:
            raise InputError([
                replace(one, where=re.sub(r"^row 2\b", f"row {number}", one.where))
                for one in error.findings
            ]) from error  # fmt: skip
        self.jobs.start(f"preview {name}", preview_as_json, study, name)
        return {}

    def _start_calibration(self) -> dict[str, Any]:
        content = _request_json()
        self.jobs.start(
            "calibration", answers.lens_calibration, self.folder, str(content["files"]),
            str(content["pattern"]), finite_number(content["square_mm"], "square_mm"),
        )  # fmt: skip
        return {}

    def _job_state(self) -> dict[str, Any]:
        return self.jobs.state(bottle.request.query.getunicode("name", ""))

    def _start_run(self) -> dict[str, Any]:
        self.run.start()
        return self.run.state()

    def _stop_run(self) -> dict[str, Any]:
        self.run.stop()
        return self.run.state()


def _request_json() -> dict[str, Any]:
    """The json object that the page sent."""
    if bottle.request.content_type.partition(";")[0] != "application/json":
        bottle.abort(415, "Expected json.")
    return parse_request(bottle.request.body.read())


def _json_response(work: Callable[[], Any]) -> str:
    """Json of what `work` returns; an error of the request as its text, with status 400."""
    bottle.response.content_type = "application/json"
    try:
        return json.dumps(work(), allow_nan=False)
    except (InputError, *BAD_REQUEST_EXCEPTIONS) as error:
        bottle.response.status = 400
        return json.dumps({"error": _bad_request_text(error)})


def _bad_request_text(error: Exception) -> str:
    """Why a request is refused."""
    if isinstance(error, InputError):
        return str(error)
    return f"a request that cannot be read ({error!r})"


def _set_security_headers() -> None:
    for name, value in SECURITY_HEADERS.items():
        bottle.response.set_header(name, value)


def _text_error_response(error: bottle.HTTPError) -> str:
    _set_security_headers()
    bottle.response.content_type = PLAIN_TEXT_CONTENT_TYPE
    return str(error.body)
