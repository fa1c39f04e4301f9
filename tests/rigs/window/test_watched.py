"""The browser page that shows a running window session."""

import re
import threading

import numpy as np
import pytest
from chromium import PROGRAM, chromium
from study_texts import TUTORIAL, changed
from tables import trial_rows
from whole_sitting import asked_to_end, sitting

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

SHORT = {"frequency_hz = [60, 240]": "frequency_hz = [60]", "repeats = 4": "repeats = 2"}


@pytest.mark.slow
@pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")
def test_watch_page_follows_finger_in_window(display, tmp_path):
    (tmp_path / "browser").mkdir()
    study = changed(TUTORIAL, SHORT)
    with sitting(tmp_path, study, "en", display) as seat, chromium(tmp_path / "browser") as tab:
        process = seat.run("--watch")
        url = re.search(r"http://127\.0\.0\.1:\d+/\S+/", process.stderr.readline())[0]
        tab.look(scheme="light", width=1920, height=1080)
        tab.open(url)
        ended = []
        finger = seat.finger(np.random.default_rng())
        hand = threading.Thread(target=lambda: ended.append(asked_to_end(process, finger)))
        hand.start()
        tab.wait_for("document.querySelectorAll('#levels figure circle').length >= 3")
        tab.wait_for("document.querySelectorAll('#touch figure').length == 2")
        tab.screenshot(tmp_path / "page.png")
        seen = {name: tab.text(f"#{name}") for name in ("title", "where", "touch", "touches", "quality")}
        assert tab.complaints() == []
        hand.join()
        tab.wait_for("document.querySelector('#lost').innerText.includes('No connection')")
    (status, _, errors), rows = ended[0], trial_rows(seat.data)
    assert (status, errors) == (0, "")
    assert "P01, session 1: tutorial" in seen["title"]
    assert "running" in seen["title"]
    assert "of at most" in seen["where"]
    assert re.search(r"\d+ samples per second", seen["touch"].replace(".0", ""))
    assert float(re.search(r"([\d.]+) N, \d+ %", seen["touches"])[1]) == pytest.approx(
        float(rows[0]["force_mean_n"]), rel=0.5
    )
    assert "Dropped frames" in seen["quality"]
    assert "Clock of keyboard" in seen["quality"]
