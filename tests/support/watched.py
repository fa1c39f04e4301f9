"""A watched data set whose page is served in a thread."""

import http.client
import json
import os
import queue
import threading
from contextlib import contextmanager
from dataclasses import dataclass
from urllib.parse import urlsplit

from patience import LONGEST_WAIT_S

from tactometry.experiments.watch.scenery import Scenery
from tactometry.experiments.watch.server import serve
from tactometry.experiments.watch.watcher import Watcher


@dataclass
class Served:
    url: str

    @property
    def port(self):
        return urlsplit(self.url).port

    @property
    def token(self):
        return urlsplit(self.url).path.strip("/")

    def connection(self):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=LONGEST_WAIT_S)

    def ask(self, path="", method="GET", *, whole_path=None, **headers):
        """Return status, text and headers of a request."""
        connection = self.connection()
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request(method, whole_path or f"/{self.token}/{path}", headers=named)
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer.status, text

    @contextmanager
    def listening(self):
        """Subscribe to changes; return a function that gives the next message."""
        connection = self.connection()
        connection.request("GET", f"/{self.token}/events")
        answer = connection.getresponse()

        def news():
            while True:
                line = answer.readline()
                assert line, "the server has closed"
                if line.startswith(b"data: "):
                    return json.loads(line.removeprefix(b"data: "))

        try:
            yield news
        finally:
            connection.close()


@contextmanager
def watched(root, **which):
    told, (reading, writing) = queue.Queue(), os.pipe()
    scenery = Scenery(Watcher(root, **which))
    with os.fdopen(reading, "rb", buffering=0) as until:
        thread = threading.Thread(target=serve, args=(scenery, 0, told.put, until), daemon=True)
        thread.start()
        try:
            yield Served(told.get(timeout=LONGEST_WAIT_S))
        finally:
            os.close(writing)
            thread.join(LONGEST_WAIT_S)
            assert not thread.is_alive()
