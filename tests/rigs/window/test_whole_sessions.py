"""Complete window sessions of the built-in studies in each language."""

import numpy as np
import pytest
from command_line import call
from emulated import available
from short_studies import SHORT, shortened
from tables import event_rows, is_sound, trial_rows
from whole_sitting import asked_to_end, forms_of, recorded_as, sitting

from tactometry.experiments.study.study_file import builtin
from tactometry.rigs.texts import languages

SOURCES = ("udp", "serial", "lsl")


def sessions():
    """Yield each study in each language, with one force source.

    `make check` runs each study once. The studies of `test_forms` already run in `make test`.
    """
    for n, name in enumerate(SHORT):
        spoken = [each for each in languages() if all(each in form.languages for form in forms_of(shortened(name)))]
        for k, language in enumerate(spoken):
            mark = pytest.mark.slow if n % len(spoken) == k else pytest.mark.soak
            yield pytest.param(name, language, SOURCES[(n + k) % len(SOURCES)], marks=mark, id=f"{name}-{language}")


def test_every_built_in_study_has_short_version():
    assert sorted(SHORT) == sorted(builtin())


@pytest.mark.parametrize(("name", "language", "source"), list(sessions()))
def test_simulated_finger_completes_session_from_pixels(display, capsys, tmp_path, name, language, source):
    if not available(source):
        pytest.skip(f"no library for {source}")
    study = shortened(name)
    with sitting(tmp_path, study, language, display, source) as seat:
        finger = seat.finger(np.random.default_rng())
        status, _, errors = asked_to_end(seat.run(), finger)
    assert (status, errors) == (0, ""), finger.kinds
    rows = trial_rows(seat.data)
    given = [float(row["response"]) for row in rows if row["response"]]
    assert given == recorded_as(finger.said, study)
    assert {row["valid"] for row in rows if row["response"]} == {"1"}
    tried = [event["trial_type"] for event in event_rows(seat.data)].count("dry_run")
    kinds = {row.get("speed_target_m_per_s", "") == "" for row in rows if row["force_mean_n"]}
    assert tried == len(kinds), "each kind of touch is tried once before its first"
    assert is_sound(seat.data)
    status, errors, _ = call(capsys, "analyse", seat.data, "--report", tmp_path / "report.html")
    assert (status, errors) == (0, "")
    assert (tmp_path / "report.html").stat().st_size > 0
