"""A headless Chromium that opens a page from disk and tells what it drew, complained of and asked the network for.

It is driven by the DevTools protocol over two pipes (--remote-debugging-pipe): JSON messages that end in a zero byte,
so that neither a driver nor a port is needed.
"""

from __future__ import annotations

import base64
import fcntl
import io
import json
import os
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

import numpy as np

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-pipe",
]
AS_3_AND_4 = """
import os, sys
os.dup2(int(sys.argv[1]), 3)
os.dup2(int(sys.argv[2]), 4)
os.execv(sys.argv[3], sys.argv[3:])
"""
SLOW_READING = "GPU stall due to ReadPixels"  # said of taking a screenshot, not of the page
PATIENCE = 60.0  # seconds for an answer: one of many processes on a slow machine


class Browser:
    """One page of a browser with a new, empty profile; use it as a context.

    complaints: what the console said of errors and warnings, and exceptions;  requests: each address asked for, the page itself among them.
    """

    def __init__(self, profile: Path, size: tuple[int, int] = (1000, 700)) -> None:
        to_read, self._to = os.pipe()
        self._from, to_write = os.pipe()
        theirs = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (to_read, to_write)]
        command = [sys.executable, "-c", AS_3_AND_4, *map(str, theirs), CHROMIUM, *FLAGS]
        command += [f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}", "about:blank"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(command, pass_fds=theirs, **quiet)
        for end in (to_read, to_write, *theirs):
            os.close(end)
        self._rest, self._number, self._session = b"", 0, None
        self.complaints: list[str] = []
        self.requests: list[str] = []

    def __enter__(self) -> Browser:
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.ask(f"{domain}.enable")
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        os.close(self._to), os.close(self._from)  # at which it ends
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def open(self, path: Path, ready: str, patience: float = PATIENCE) -> None:
        """Open the file and wait until the JavaScript expression `ready` is true."""
        self.ask("Page.navigate", url=path.resolve().as_uri())
        until = time.monotonic() + patience
        while not self.value(ready):
            if time.monotonic() > until:
                raise TimeoutError(f"{path.name}: {ready!r} never became true; {self.complaints}")
            time.sleep(0.1)

    def value(self, expression: str) -> object:
        """What the JavaScript expression is on the page, once its promise is kept."""
        told = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        return told["result"].get("value")

    def picture(self) -> np.ndarray:
        """What the window shows, (height, width, 3) of 0 to 255."""
        from PIL import Image

        told = self.ask("Page.captureScreenshot", format="png")
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(told["data"]))).convert("RGB"))

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Press the left button at `start` [pixels], move to `end`, let go."""
        self._mouse("mousePressed", *start)
        for share in (0.25, 0.5, 0.75, 1.0):
            self._mouse("mouseMoved", *(a + share * (b - a) for a, b in zip(start, end, strict=True)))
        self._mouse("mouseReleased", *end)

    def _mouse(self, kind: str, x: float, y: float) -> None:
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    def ask(self, method: str, **parameters: object) -> dict:
        """Send a command and wait for its answer; note events on the way."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while (told := self._next()).get("id") != self._number:
            self._note(told)
        if "error" in told:
            raise RuntimeError(f"{method}: {told['error']}")
        return told["result"]

    def _next(self) -> dict:
        while b"\0" not in self._rest:
            if not select.select([self._from], [], [], PATIENCE)[0]:
                raise TimeoutError("the browser says nothing")
            read = os.read(self._from, 1 << 20)
            if not read:
                raise RuntimeError("the browser ended")
            self._rest += read
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def _note(self, told: dict) -> None:
        event = told.get("params", {})
        match told.get("method"):
            case "Runtime.consoleAPICalled" if event["type"] in ("error", "warning", "assert"):
                self.complaints.append(" ".join(str(arg.get("value")) for arg in event["args"]))
            case "Runtime.exceptionThrown":
                self.complaints.append(json.dumps(event["exceptionDetails"]))
            case "Log.entryAdded" if event["entry"]["level"] in ("error", "warning"):
                if SLOW_READING not in event["entry"]["text"]:
                    self.complaints.append(event["entry"]["text"])
            case "Network.requestWillBeSent":
                self.requests.append(event["request"]["url"])
