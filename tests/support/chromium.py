"""Debian's Chromium without a window, spoken to through its DevTools protocol: two pipes and JSON, no library."""

import base64
import json
import os
import shutil
import subprocess
import time
from contextlib import contextmanager

from patience import LONGEST_WAIT_S

PROGRAM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = (
    *("--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
    *("--disable-background-networking", "--disable-component-update", "--no-first-run", "--hide-scrollbars"),
)

OWN = ("http://127.0.0.1:", "data:", "about:")


class Tab:
    def __init__(self, to_browser, from_browser):
        self._to, self._from, self._rest, self._n = to_browser, from_browser, b"", 0
        self._session = None
        self.told = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method, **params):
        """Call a protocol method and keep the events received meanwhile."""
        self._n += 1
        message = {"id": self._n, "method": method, "params": params}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._n:
                assert "error" not in answer, answer["error"]
                return answer["result"]
            self.told.append(answer)

    def _next(self):
        while b"\0" not in self._rest:
            data = os.read(self._from, 1 << 16)
            assert data, "the browser has ended"
            self._rest += data
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def open(self, url):
        self.call("Page.navigate", url=url)
        self.wait_for("document.readyState === 'complete'")

    def value(self, expression):
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait_for(self, expression):
        end_s = time.monotonic() + LONGEST_WAIT_S
        while not self.value(expression):
            assert time.monotonic() < end_s, f"never true: {expression}; the page reads {self.text()!r}"
            time.sleep(0.05)

    def text(self, selector="body"):
        return self.value(f"document.querySelector({selector!r})?.innerText")

    def look(self, *, scheme, width, height, forced=False):
        """Dark or light, at this size."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        if forced:
            features.append({"name": "forced-colors", "value": "active"})
        self.call("Emulation.setEmulatedMedia", features=features)
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def screenshot(self, path, *, whole=True):
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))

    def named(self):
        """Return pairs of role and name in the accessibility tree."""
        nodes = self.call("Accessibility.getFullAXTree")["nodes"]
        told = ((node["role"]["value"], node.get("name", {}).get("value", "")) for node in nodes if not node["ignored"])
        return [(role, name) for role, name in told if name]

    def complaints(self):
        """Return console errors and requests that leave the loopback."""
        self.value("1")
        found = []
        for message in self.told:
            params = message.get("params", {})
            match message.get("method"):
                case "Log.entryAdded" if params["entry"]["level"] == "error":
                    found.append(params["entry"]["text"])
                case "Runtime.exceptionThrown":
                    found.append(params["exceptionDetails"]["text"])
                case "Network.requestWillBeSent" if not params["request"]["url"].startswith(OWN):
                    found.append(params["request"]["url"])
        return found


@contextmanager
def chromium(folder):
    """Yield a tab of a new browser whose files are in a folder."""
    to_browser, from_browser = os.pipe(), os.pipe()
    environment = {**os.environ, "HOME": str(folder), "XDG_RUNTIME_DIR": str(folder)}
    # the browser reads from 3 and writes to 4: bash assigns the pipes to these numbers
    command = f'exec "$@" 3<&{to_browser[0]} 4>&{from_browser[1]}'
    words = ["/bin/bash", "-c", command, "bash", PROGRAM, *FLAGS, f"--user-data-dir={folder / 'profile'}"]
    silent, ends = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL), (to_browser[0], from_browser[1])
    browser = subprocess.Popen(words, pass_fds=ends, env=environment, **silent)
    for end in ends:
        os.close(end)
    try:
        yield Tab(to_browser[1], from_browser[0])
    finally:
        os.close(to_browser[1])  # the browser ends with its pipe
        try:
            browser.wait(10)
        except subprocess.TimeoutExpired:
            browser.kill()
            browser.wait()
        os.close(from_browser[0])
