"""What is seen of a session that runs, and who may see it."""

import re
import socket
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from places import ROOT
from tutorial_session import journal_of, live
from watched import watched

from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.watch import view
from tactometry.experiments.watch.curve import answers_of, band_of, curve_plot
from tactometry.experiments.watch.drawn import Drawn, TouchDrawn
from tactometry.experiments.watch.page import sections
from tactometry.experiments.watch.plots import MOST_TICKS, levels_plot, ruler_over, samples_plot
from tactometry.experiments.watch.sight import Sight
from tactometry.experiments.watch.traces import MOST_BINS, draw_touch, thinned
from tactometry.experiments.watch.watcher import LOOK_AROUND_S, TRY_AGAIN_S, Watcher
from tactometry.records.data_set import Session
from tactometry.records.journal import read
from tactometry.records.traces import TraceFiles
from tactometry.session.answer import Done, Marked, Touched
from tactometry.session.progress import AnsweredTouch, PartAhead, Progress
from tactometry.session.request import Press, Record
from tactometry.trials.trial import REASONS, Trial

RECORDED = sorted(path.parent for path in (ROOT / "tests" / "recorded").glob("*/journals"))


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    root = tmp_path_factory.mktemp("watched")
    live(root)
    return journal_of(root).read_bytes(), (root / "study.toml").read_bytes(), journal_of(root).name


@pytest.fixture
def path(content, tmp_path):
    """An empty journal of a data set."""
    (tmp_path / "journals").mkdir()
    (tmp_path / "study.toml").write_bytes(content[1])
    return tmp_path / "journals" / content[2]


def whole(content, n_lines):
    return b"".join(content[0].splitlines(keepends=True)[:n_lines])


class Clock:
    now_s = 0.0

    def __call__(self):
        return self.now_s


@pytest.mark.parametrize("root", RECORDED, ids=lambda root: root.name)
def test_the_page_of_every_recorded_data_set_is_drawn(root):
    sight = Watcher(root).look()
    answers = answers_of(sight.progress)
    drawn = Drawn() if answers is None else Drawn(curve_plot(answers, band_of(answers)))
    assert sight.name
    assert sight.parts
    assert all(sections(sight, drawn)[name] for name in ("title", "where", "levels", "conditions"))


def test_the_same_sight_is_given_as_long_as_nothing_is_new(content, path):
    path.write_bytes(whole(content, 20))
    watcher = Watcher(path.parents[1])
    sight = watcher.look()
    assert watcher.look() is sight
    path.write_bytes(whole(content, 21))
    assert watcher.look() is not sight


def test_a_folder_without_a_session_is_waited_for(tmp_path, content, path):
    clock = Clock()
    watcher = Watcher(path.parents[1], clock=clock)
    assert watcher.look().state == "no session yet"
    path.write_bytes(whole(content, 20))
    clock.now_s = LOOK_AROUND_S
    assert watcher.look().state == "running"
    assert Watcher(tmp_path / "nowhere").look().state == "no session yet"


def test_a_session_that_begins_is_followed_in_the_place_of_the_last_one(tmp_path):
    clock = Clock()
    live(tmp_path)
    watcher = Watcher(tmp_path, clock=clock)
    assert view.title(watcher.look()).startswith("P01, session 1")
    live(tmp_path, Who("P02", seed=1))
    clock.now_s = LOOK_AROUND_S
    assert view.title(watcher.look()).startswith("P02, session 1")
    assert view.title(Watcher(tmp_path, "P01", 1).look()).startswith("P01, session 1")
    assert not Watcher(tmp_path, "P03").look().name


def test_a_damaged_journal_is_told_with_its_line_and_what_was_seen_stays(content, path):
    clock = Clock()
    path.write_bytes(whole(content, 20))
    watcher = Watcher(path.parents[1], clock=clock)
    n_trials = watcher.look().progress.tally.n_trials
    path.write_bytes(whole(content, 20) + b'{"event":"remark"}\n')
    sight = watcher.look()
    assert sight.state == "cannot be read"
    assert "line 21" in view.alerts(sight)[0]
    assert sight.progress.tally.n_trials == n_trials
    path.write_bytes(content[0])
    clock.now_s = TRY_AGAIN_S
    assert watcher.look().state == "over"
    assert not view.alerts(watcher.look())


def test_a_journal_that_is_cut_shows_what_is_left(content, path):
    path.write_bytes(content[0])
    watcher = Watcher(path.parents[1])
    watcher.look()
    path.write_bytes(whole(content, 20))
    sight = watcher.look()
    assert sight.progress.tally.n_trials == len(read(path).trials)
    assert sight.state == "running"


def test_a_data_set_without_its_study_is_shown_without_what_is_to_come(content, path):
    path.write_bytes(whole(content, 20))
    (path.parents[1] / "study.toml").unlink()
    sight = Watcher(path.parents[1]).look()
    assert sight.parts == ()
    assert "Time left" not in [row.name for row in view.where(sight)]


def test_where_it_stands_in_the_middle_of_a_session(content, path):
    path.write_bytes(whole(content, 60))
    sight = Watcher(path.parents[1]).look()
    named = {row.name: row.value for row in view.where(sight)}
    trials = read(path).trials
    n_valid = sum(trial.valid for trial in trials)
    assert named["Part"] == "1 of 2"
    assert named["Time left"].startswith("at most ")
    assert named["Last trial"].startswith(f"number {trials[-1].trial}, ")
    assert [share.words for share in view.shares(sight)] == [f"{n_valid} of at most 20", f"{n_valid} of at most 40"]


def test_before_a_track_is_aborted_the_page_warns_and_then_it_says_so(content, path):
    path.write_bytes(whole(content, 20))
    sight, lost = Watcher(path.parents[1]).look(), None
    for attempt in range(1, 6):
        row = Trial(1, 99, {}, "staircase", 1.0, "V", "yes_no", None, valid=False, attempt=attempt)
        lost = replace(sight, progress=_with(sight.progress, row, "block 1 is aborted" if attempt == 5 else None))
        sight = lost
        if attempt == 4:
            assert view.alerts(sight) == ["Careful: the last 4 touches did not count: 1 more aborts this condition."]
    assert view.alerts(sight) == ["Block 1 is aborted."]
    assert view.condition_rows(sight.progress)[0].state == "aborted"


def _with(progress, row, aborted):
    return progress.after(Record(row, aborted), Done(progress.at_s + 1.0))


def test_each_reason_has_its_words():
    progress = Progress(n_touches=99, reasons=dict.fromkeys(REASONS, 1))
    assert view.reasons(progress).startswith(f"{len(REASONS)} of 99 touches not valid: ")
    assert "_" not in view.reasons(progress)


def test_what_is_not_as_it_should_be_is_marked():
    progress = Progress(n_frames=1000, n_dropped_frames=50, n_gaps=2, reasons={"sensor_lost": 1})
    assert [row.mark for row in view.quality(progress)] == [True, True, True]
    assert not any(row.mark for row in view.quality(Progress(n_frames=1000, n_dropped_frames=9)))


def test_what_a_person_wrote_is_text_and_no_html():
    sight = Sight("a", problem="<script>alert(1)</script>", progress=Progress(factors={"<b>": "<i>"}, n_parts=1))
    drawn = "".join(sections(sight, Drawn()).values())
    assert "<script>" not in drawn
    assert "<i>" not in drawn
    assert "&lt;script&gt;" in drawn


def test_the_curve_is_of_the_present_condition_without_practice():
    def rows(n, yes, **known):
        return [Trial(1, n + i, {"f": 1.0}, "staircase", 5.0 * i, "dB", "yes_no", i > 2, **known) for i in range(yes)]

    progress = Progress()
    for row in (
        *rows(1, 6),
        *rows(100, 6, practice=True),
        Trial(1, 50, {"f": 1.0}, "s", None, "dB", "yes_no", 1, catch=True),
    ):
        progress = _with(progress, row, None)
    answers = answers_of(progress)
    assert sum(answers.n_trials) == 6
    assert (answers.n_false_alarms, answers.n_catch) == (1, 1)
    band = band_of(answers)
    assert ((band.low <= band.median) & (band.median <= band.high)).all()


def test_answers_to_a_questionnaire_are_no_catch_trials_and_leave_the_levels_where_they_were():
    progress = _with(Progress(), Trial(1, 1, {"f": 1.0}, "staircase", 5.0, "dB", "yes_no", 1), None)
    form = Trial(2, 2, {"f": 1.0}, "sus", None, "", "rating", 1.0, item="SUS1")
    sight = Sight("a", progress=_with(progress, form, None))
    assert {row.name: row.value for row in view.where(sight)}["Last trial"] == "sus, SUS1: 1"
    assert [mark.kind for mark in view.level_plots(sight.progress)[0].marks] == ["yes"]
    assert view.unit(sight.progress) == "dB"
    assert [row.state for row in view.condition_rows(sight.progress)] == [""]


def test_levels_of_several_units_each_have_theirs():
    progress = _with(Progress(), Trial(1, 1, {}, "staircase", 5.0, "dB", "yes_no", 1), None)
    assert [row.level for row in view.condition_rows(progress)] == ["5"]
    progress = _with(progress, Trial(2, 2, {}, "staircase", 7.0, "V", "yes_no", 1), None)
    assert view.unit(progress) == ""
    assert [row.level for row in view.condition_rows(progress)] == ["7 V", "5 dB"]


def test_a_rating_of_one_is_no_yes():
    progress = _with(Progress(), Trial(1, 1, {}, "attrakdiff", 24.0, "dB", "rating", 1.0, item="PQ1"), None)
    assert [mark.kind for mark in view.level_plots(progress)[0].marks] == ["neutral"]


def test_too_few_answers_have_no_curve():
    progress = _with(Progress(), Trial(1, 1, {}, "staircase", 5.0, "dB", "yes_no", 1), None)
    assert answers_of(progress) is None
    assert answers_of(_with(progress, Trial(1, 2, {}, "s", 5.0, "dB", "magnitude", 7.0), None)) is None


def test_marks_lie_where_the_axes_say():
    progress = Progress()
    for n, level in enumerate((10.0, 8.0, 6.0, 8.0), 1):
        progress = _with(progress, Trial(1, n, {}, "staircase", level, "dB", "yes_no", 1, valid=n != 2), None)
    plot = levels_plot("levels", "a title", progress.track)
    marks = [mark for mark in plot.marks if mark.kind != "reversal"]
    assert [mark.kind for mark in marks] == ["yes", "invalid", "yes", "yes"]
    assert [plot.y.at(level) for level in (10.0, 8.0, 6.0, 8.0)] == [mark.y for mark in marks]
    assert [mark.x for mark in marks if mark.kind == "reversal"] == []
    assert [mark.x for mark in plot.marks if mark.kind == "reversal"] == [plot.x.at(3)]


def test_one_value_has_an_axis_too():
    assert ruler_over([3.0], 0.0, 10.0).at(3.0) == 5.0
    assert ruler_over([], 0.0, 10.0).ticks


@given(low=st.floats(-1e6, 1e6), exponent=st.floats(-4, 6), share=st.floats(0, 1))
def test_every_axis_has_some_round_ticks_within_it(low, exponent, share):
    ruler = ruler_over([low, low + 10.0**exponent], 0.0, 100.0, margin=share)
    assert 2 <= len(ruler.ticks) <= MOST_TICKS
    slack = 1e-8 * (ruler.high - ruler.low)
    assert all(ruler.low - slack <= tick <= ruler.high + slack for tick in ruler.ticks)


def test_samples_that_were_lost_leave_no_line():
    plot = samples_plot("force", "Force", "force (N)", [[(0.0, 1.0), (0.1, float("nan")), (0.2, 1.2)]], (0.8, 1.2))
    assert "nan" not in plot.strokes[0].points
    assert samples_plot("force", "Force", "force (N)", [[(0.0, float("nan"))]]) is None


def test_of_many_samples_the_extremes_stay():
    times_s = np.arange(10_000) / 1000
    values = np.sin(times_s)
    values[4321], values[77] = 5.0, np.nan
    points = thinned(times_s, values)
    assert len(points) <= 2 * MOST_BINS
    assert (times_s[4321], 5.0) in points
    assert [time_s for time_s, _ in points] == sorted(time_s for time_s, _ in points)


def kept_touch(root, n_samples=3000):
    """A touch of three seconds from a second before its onset, whose force and place are kept in a data set."""
    times_s = 9.0 + np.arange(n_samples) / 1000
    traces = TraceFiles(root, Session("P01", 1, "tutorial"))
    force = np.column_stack([times_s, 1.0 + 0.1 * np.sin(times_s)])
    force[17, 1] = np.nan
    parts = (
        traces.keep("force", force, 1000.0),
        traces.keep("position", np.column_stack([times_s, times_s / 100]), 1000.0),
    )
    traces.close()
    answer = Touched(10.0, 12.0, "0", force_mean_n=1.0, trace=parts)
    return AnsweredTouch(Press("tone", 12.0, 1.0, 1.0, 0.2, 0.5, 20.0), answer)


def test_force_and_place_of_the_last_touch_are_drawn_with_the_band_that_was_asked_for(tmp_path):
    force, place = draw_touch(tmp_path, kept_touch(tmp_path)).plots
    assert (force.title, place.title) == ("Force", "Position")
    assert "1000.0 samples per second, 1.00 ms apart at most, 1 lost" in force.words
    assert [area.kind for area in force.areas] == ["playing", "wanted"]
    band = {float(point.split(",")[1]) for point in force.areas[1].points.split()}
    assert band == {force.y.at(0.8), force.y.at(1.2)}
    assert [area.kind for area in place.areas] == ["playing"]
    assert force.x.low == pytest.approx(-1.0)


def test_traces_that_are_damaged_or_gone_are_told(tmp_path):
    touch = kept_touch(tmp_path)
    file = tmp_path / touch.answer.trace[0].file
    file.write_bytes(file.read_bytes()[:-10])
    assert "force_physio" in draw_touch(tmp_path, touch).problem
    file.unlink()
    assert "force_physio" in draw_touch(tmp_path, touch).problem


def test_a_touch_without_samples_has_no_plot(tmp_path):
    touch = AnsweredTouch(Press("tone", 12.0, 1.0, 1.0, 0.2, 0.5, 20.0), Touched(10.0, 12.0, "0"))
    assert draw_touch(tmp_path, touch) == TouchDrawn()


def test_marks_on_a_page_of_a_questionnaire_are_seen_past(content, path):
    path.write_bytes(whole(content, 20))
    sight = Watcher(path.parents[1]).look()
    assert sight.after([Marked("sus", (1.0, None), 3.0)]).progress == sight.progress


def test_left_out_parts_have_no_share():
    assert view.shares(Sight("a", parts=(PartAhead(lasts_s=30.0),))) == []


pytest.importorskip("starlette")
pytest.importorskip("uvicorn")


@pytest.fixture(scope="module")
def served(content, tmp_path_factory):
    root = tmp_path_factory.mktemp("served")
    live(root)
    with watched(root) as page:
        yield page


def test_the_page_and_its_files_are_served(served):
    assert served.ask()[0] == 200
    assert served.ask("page.css")[0] == served.ask("page.js")[0] == 200
    assert "P01, session 1" in served.ask()[1]


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "evil.example"}, 403),
        ({"Host": "127.0.0.1"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Sec_Fetch_Site": "cross-site"}, 403),
        ({"Sec_Fetch_Site": "same-site"}, 403),
        ({"Sec_Fetch_Site": "none"}, 200),
    ],
)
def test_foreign_hosts_and_pages_are_refused(served, headers, status):
    for path in ("", "events", "page.js"):
        if status == 200 and path == "events":
            continue  # it has no end
        assert served.ask(path, **headers)[0] == status


def test_without_its_token_nothing_is_told(served):
    for path in (
        "/",
        "/events",
        "/page.js",
        f"/{served.token[:-1]}/",
        f"/{served.token}x/",
        "//",
        f"/x/{served.token}/",
    ):
        status, text = served.ask(whole_path=path)
        assert (status, text) == (404, "")


def test_nothing_but_the_page_is_served(served):
    for path in ("../study.toml", "..%2fstudy.toml", "study.toml", "page.html", "page.js/..", "journals/"):
        assert served.ask(path)[0] == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_nothing_can_be_done_but_to_look(served, method):
    assert served.ask(method=method)[0] == 405


def test_only_the_loopback_is_listened_at(served):
    with socket.socket() as other:  # another address of this computer, as another one would come by
        assert other.connect_ex(("127.0.0.2", served.port)) != 0


def test_a_page_says_that_it_may_load_nothing_from_elsewhere(served):
    connection = served.connection()
    connection.request("GET", f"/{served.token}/")
    headers = connection.getresponse().headers
    assert headers["Content-Security-Policy"].startswith("default-src 'none'")
    assert headers["Cache-Control"] == "no-store"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "server" not in headers
    connection.close()
    assert not re.search(r"https?:", served.ask()[1] + served.ask("page.css")[1] + served.ask("page.js")[1])


def test_two_pages_have_two_tokens(served, tmp_path):
    with watched(tmp_path) as other:
        assert other.token != served.token
        assert len(other.token) >= 32


def test_who_listens_is_told_what_changes_alone(content, path):
    path.write_bytes(whole(content, 20))
    with watched(path.parents[1]) as page, page.listening() as news:
        first = news()
        assert set(first) >= {"title", "where", "levels", "quality"}
        path.write_bytes(whole(content, 23))
        second = news()
        assert "where" in second
        assert "quality" not in second
        path.write_bytes(content[0])
        assert "over" in news()["title"]


def test_a_port_that_is_taken_is_one_sentence(served):
    from tactometry.errors import DeviceFailed
    from tactometry.experiments.watch.scenery import Scenery
    from tactometry.experiments.watch.server import serve

    with pytest.raises(DeviceFailed, match=rf"--port: cannot listen at 127.0.0.1:{served.port}"):
        serve(Scenery(Watcher(ROOT)), served.port, print)
