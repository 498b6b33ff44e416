"""Chromium without a screen, for tests of the page."""

from __future__ import annotations

import json
import os
import select
import subprocess
from pathlib import Path
from typing import Any

ERROR_EVENTS = ("Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled")
PAGE_READY_SCRIPT = "new Promise(r => document.readyState === 'complete' ? r() : (onload = r))"


class Browser:
    """Chromium without a screen, controlled over its pipe."""

    def __init__(self, program: str, profile: Path, width: int) -> None:
        to_read, self.to = os.pipe()
        self.back, from_write = os.pipe()
        command = [
            program, "--headless", "--no-sandbox", "--disable-gpu", f"--window-size={width},900",
            "--autoplay-policy=no-user-gesture-required", "--remote-debugging-pipe",
            f"--user-data-dir={profile}", "about:blank",
        ]  # fmt: skip
        shell = ["bash", "-c", f'exec "$@" 3<&{to_read} 4>&{from_write}', "-", *command]
        self.process = subprocess.Popen(
            shell, pass_fds=(to_read, from_write), stdout=-3, stderr=-3, start_new_session=True
        )
        self.count, self.rest, self.events = 0, b"", []

    def call(self, method: str, session: str | None = None, **parameters: object) -> dict:
        self.count += 1
        order = {"id": self.count, "method": method, "params": parameters}
        os.write(self.to, json.dumps(order | ({"sessionId": session} if session else {})).encode())
        os.write(self.to, b"\0")
        while True:
            message = self._next()
            if message.get("id") == self.count:
                assert "error" not in message, message
                return message["result"]
            self.events.append(message)

    def _next(self) -> dict:
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.back], [], [], 60)
            assert ready, "chromium does not answer"
            self.rest += os.read(self.back, 1 << 20)
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def close(self) -> None:
        self.call("Browser.close")
        self.process.wait(30)


class Tab:
    """One page open in a browser."""

    def __init__(self, browser: Browser, page: Path | str, *, phone: bool = False) -> None:
        self.browser = browser
        target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        if phone:
            self.call("Emulation.setDeviceMetricsOverride", width=390, height=844,
                      deviceScaleFactor=2, mobile=True)  # fmt: skip
        self.call("Page.navigate", url=page if isinstance(page, str) else page.as_uri())
        self.evaluate(PAGE_READY_SCRIPT)

    def call(self, method: str, **parameters: object) -> dict:
        return self.browser.call(method, self.session, **parameters)

    def evaluate(self, script: str) -> Any:
        """Value of a script, promises awaited."""
        result = self.call("Runtime.evaluate", expression=script, awaitPromise=True,
                         returnByValue=True)  # fmt: skip
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def press(self, key: str, code: int, text: str = "") -> None:
        for kind in ("keyDown", "keyUp"):
            more = {"text": text} if text and kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                      windowsVirtualKeyCode=code, **more)  # fmt: skip

    def console_messages(self) -> list[dict]:
        """Errors, warnings and messages on the console."""
        return [event for event in self.browser.events if event.get("method") in ERROR_EVENTS]
