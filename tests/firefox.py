"""Firefox without a screen, controlled by its Marionette protocol, for tests of the page."""

from __future__ import annotations

import json
import socket
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

KEY_CODES = {"Tab": "\ue004", "Enter": "\ue007", "ArrowRight": "\ue014", "End": "\ue010",
        "Home": "\ue011", "Escape": "\ue00c"}  # fmt: skip
EVALUATE_SCRIPT = """const done = arguments[1];
const script = document.createElement("script");
script.textContent = `window.evaluated = ${arguments[0]}`;
document.head.append(script);
script.remove();
Promise.resolve(window.evaluated)
  .then((value) => done({ value }), (error) => done({ error: `${error}` }));"""
NARROW_WINDOW = """const shell = Services.wm.getMostRecentWindow("navigator:browser").document;
shell.documentElement.style.setProperty("min-width", "0", "important");"""
COLLECT_ERRORS_SCRIPT = """return Services.console.getMessageArray()
  .filter((one) => one instanceof Ci.nsIScriptError && one.sourceName.startsWith(arguments[0]))
  .map((one) => one.message);"""
START_S = 120


class Firefox:
    """Firefox without a screen."""

    def __init__(self, program: str, profile: Path) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        profile.mkdir(parents=True)
        (profile / "user.js").write_text(f'user_pref("marionette.port", {port});\n')
        command = [program, "--headless", "--marionette", "--remote-allow-system-access",
                   "--no-remote", "--profile", str(profile)]  # fmt: skip
        self.process = subprocess.Popen(command, stdout=-3, stderr=-3, start_new_session=True)
        self.socket, self.rest, self.count = self._connected(port), b"", 0
        self._next()
        self.call("WebDriver:NewSession", capabilities={})
        self.call("WebDriver:SetTimeouts", script=60_000)

    def _connected(self, port: int) -> socket.socket:
        end = time.monotonic() + START_S
        while True:
            try:
                return socket.create_connection(("127.0.0.1", port), timeout=START_S)
            except OSError:
                assert time.monotonic() < end, "firefox does not answer"
                assert self.process.poll() is None, "firefox ended"
                time.sleep(0.2)

    def call(self, command: str, **parameters: object) -> Any:
        self.count += 1
        order = json.dumps([0, self.count, command, parameters]).encode()
        self.socket.sendall(b"%d:%s" % (len(order), order))
        _, number, error, result = self._next()
        assert number == self.count
        assert error is None, error
        return result

    def _next(self) -> Any:
        while b":" not in self.rest:
            self.rest += self._received()
        length, self.rest = self.rest.split(b":", 1)
        while len(self.rest) < int(length):
            self.rest += self._received()
        text, self.rest = self.rest[: int(length)], self.rest[int(length) :]
        return json.loads(text)

    def _received(self) -> bytes:
        found = self.socket.recv(1 << 20)
        if not found:
            raise ConnectionError("firefox ended the connection")
        return found

    def in_browser(self, script: str, *arguments: object) -> Any:
        """Value of a script with the rights of the browser itself."""
        self.call("Marionette:SetContext", value="chrome")
        result = self.call("WebDriver:ExecuteScript", script=script, args=list(arguments))
        self.call("Marionette:SetContext", value="content")
        return result["value"]

    def close(self) -> None:
        with suppress(ConnectionError):  # it may end before it answers
            self.call("Marionette:Quit", flags=["eForceQuit"])
        self.process.wait(60)


class FirefoxTab:
    """The one page that is open, with the interface of `browser.Tab`."""

    def __init__(self, browser: Firefox, page: Path, *, phone: bool = False) -> None:
        self.browser, self.url = browser, page.as_uri()
        browser.in_browser(NARROW_WINDOW)
        browser.call("WebDriver:SetWindowRect", width=390 if phone else 1300, height=900)
        browser.call("WebDriver:Navigate", url=self.url)

    def evaluate(self, script: str) -> Any:
        """Value of a script, promises awaited."""
        call = self.browser.call(
            "WebDriver:ExecuteAsyncScript", script=EVALUATE_SCRIPT, args=[script]
        )
        assert "error" not in call["value"], call
        return call["value"].get("value")

    def press(self, key: str, _code: int = 0, _text: str = "") -> None:
        value = KEY_CODES.get(key, key)
        actions = [{"type": kind, "value": value} for kind in ("keyDown", "keyUp")]
        keyboard = {"type": "key", "id": "keyboard", "actions": actions}
        self.browser.call("WebDriver:PerformActions", actions=[keyboard])

    def console_messages(self) -> list[str]:
        """Errors and warnings of the page's scripts and styles."""
        return list(self.browser.in_browser(COLLECT_ERRORS_SCRIPT, self.url))
