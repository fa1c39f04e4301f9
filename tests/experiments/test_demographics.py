"""Consent, and questions about a person with custom choices, from the docs' examples."""

import io
import json
import re

import pytest
from command_line import call, output, refused
from places import DOCS
from study_texts import TUTORIAL as CONSTANT_TUTORIAL
from tables import is_sound, trial_rows

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.reading.quality import Exclusion
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse
from tactometry.questionnaire import NOT_SAID, load_choices, shipped_choices
from tactometry.records.journal import read
from tactometry.rigs.texts import languages, texts_in
from tactometry.session.request import ABOUT, Choose, Fill, Show

PAGE = (DOCS / "reference" / "studies.md").read_text("utf-8")
SECTION = PAGE.partition("### Consent, and questions about a person")[2].partition("\n### ")[0]
SHIPPED, OWN = re.findall(r"```toml\n(.*?)```", SECTION, re.S)
TUTORIAL = CONSTANT_TUTORIAL.replace("repeats = 4", "repeats = 1")
CONSENT, _, INQUIRY = SHIPPED.partition("\n")
STUDY = f"{CONSENT}\n{TUTORIAL}\n{INQUIRY}\n{OWN}"
ITEMS = ["age_band", "handedness", "gender", "screens"]


@pytest.fixture
def study(tmp_path):
    (tmp_path / "s.toml").write_text(STUDY, "utf-8")
    return tmp_path / "s.toml"


@pytest.fixture
def simulated(study, tmp_path, capsys):
    output(capsys, "simulate", study, "--participants", 4, "--seed", 1, "--out", tmp_path / "d")
    return tmp_path / "d"


def on_console(monkeypatch, capsys, study, root, lines, *more):
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    words = ("run", study, "--participant", "P01", "--rig", "console", "--seed", 1, "--out", root, *more)
    return call(capsys, *words)


def pages_of(root):
    [journal] = (root / "journals").glob("*_study-tutorial.jsonl")
    names = {Show: "message", Choose: "question", Fill: "form"}
    requests = [entry.request for entry in read(journal).entries if type(entry.request) in names]
    return [getattr(request, names[type(request)]) for request in requests]


def test_each_question_has_a_page_and_a_row(study, tmp_path, capsys, monkeypatch):
    root = tmp_path / "d"
    status, errors, said = on_console(monkeypatch, capsys, study, root, "yes\n3\nleft\n0\ndaily\n" + "1\n" * 40)
    assert status == 0, errors
    assert "How old are you? (1 = under 18, 2 = 18 to 24," in said
    assert said.count("0 = prefer not to say") == len(ITEMS)
    rows = trial_rows(root)[: len(ITEMS)]
    assert [(row["item"], row["response"]) for row in rows] == list(zip(ITEMS, "3201", strict=True))
    assert {(row["task"], row["level"], row["trial"]) for row in rows} == {("rating", "", "1"), ("rating", "", "2")}
    assert is_sound(root)
    first = ["welcome", "consent", "agree", "questions_first", f"{ABOUT}demographics.age_band"]
    assert pages_of(root)[: len(first)] == first


def test_stored_answer_is_not_requested_again(study, tmp_path, capsys, monkeypatch):
    root = tmp_path / "d"
    on_console(monkeypatch, capsys, study, root, "yes\n3\n2\n")  # the input ends at the third question
    assert [row["response"] for row in trial_rows(root)] == ["3", "2"]
    status, errors, _ = on_console(monkeypatch, capsys, study, root, "1\n" * 40, "--resume")
    assert status == 0, errors
    assert [name.rpartition(".")[2] for name in pages_of(root) if name.startswith(ABOUT)] == ITEMS


def test_session_asks_nothing_without_consent(study, tmp_path, capsys, monkeypatch):
    root = tmp_path / "d"
    status, _, said = on_console(monkeypatch, capsys, study, root, "no\n")
    assert status == 1
    assert "next: nothing to analyse: no block was finished" in said
    assert "Your answers are kept under a code" in said
    assert "Nothing else will be asked" in said
    assert pages_of(root) == ["welcome", "consent", "agree", "declined"]
    assert trial_rows(root) == []
    assert is_sound(root)


def test_refused_consent_leaves_other_data_readable(study, tmp_path, capsys, monkeypatch):
    root = tmp_path / "d"
    on_console(monkeypatch, capsys, study, root, "no\n")
    for words in (("analyse", root), ("export", root, "--to", "psych-ds", "--out", tmp_path / "x")):
        assert call(capsys, *words)[0] == 2, "there is nothing else"
    status, _, _ = on_console(
        monkeypatch, capsys, study, root, "yes\n3\n1\n0\n1\n" + "1\n" * 40, "--participant", "P02"
    )
    assert status == 0
    assert "1 session without trials left out:" in output(capsys, "analyse", root)
    for to in ("psychopy", "bids", "psych-ds"):
        output(capsys, "export", root, "--to", to, "--out", tmp_path / to)


def test_simulated_demographics_are_valid_and_counted(simulated, tmp_path, capsys):
    for command in ("validate", "replay"):
        output(capsys, command, simulated)
    report = tmp_path / "report.html"
    found = analyse(simulated, report=report)
    counts = found.table("categories")
    assert dict(counts.groupby("item")["n"].sum()) == dict.fromkeys(ITEMS, 4)
    assert found.forms == ()
    assert not any("not analysed" in warning for warning in found.warnings)
    page = report.read_text("utf-8")
    assert all(words in page for words in ("About the participants", "Which hand do you write with?", "65 or older"))
    assert (tmp_path / "report_tables" / "categories.csv").is_file()


def test_exports_hold_the_answers_apart_from_the_trials(simulated, tmp_path, capsys):
    for to in ("psychopy", "bids", "r"):
        output(capsys, "export", simulated, "--to", to, "--out", tmp_path / to)
    [events] = (tmp_path / "bids" / "sub-P01").rglob("*events.tsv")
    [asked] = (tmp_path / "bids" / "sub-P01").rglob("*task-demographics_beh.tsv")
    assert "age_band" in asked.read_text("utf-8")
    assert "age_band" not in events.read_text("utf-8")
    assert not any("rating" in file.read_text("utf-8") for file in (tmp_path / "r").glob("*.R"))


YEARS = '\n[[forms.habits.items]]\nid = "age_years"\nprompt = { en = "Years?", fr = "?" }\nlow = 18\nhigh = 99\n'
ALLOWED = STUDY.replace('form = "habits"', 'form = "habits"\nidentifies = true')


def test_numeric_question_is_shown_and_documented(study, tmp_path, capsys, monkeypatch):
    study.write_text(ALLOWED + YEARS, "utf-8")
    root = tmp_path / "d"
    status, errors, said = on_console(monkeypatch, capsys, study, root, "yes\n3\n1\n0\n1\n1\n17\n37\n" + "1\n" * 40)
    assert status == 0, errors
    assert "Years? (a number from 18 to 99):" in said
    assert [row["response"] for row in trial_rows(root) if row["item"] == "age_years"] == ["37"]
    described = json.loads((root / "dataset_description.json").read_text("utf-8"))["description"]
    assert described.endswith("Answers could tell who a participant is: age_years.")
    assert is_sound(root)


def test_skipped_number_is_empty_and_never_reported(study, tmp_path, capsys):
    study.write_text(ALLOWED + YEARS, "utf-8")
    root = tmp_path / "d"
    output(capsys, "simulate", study, "--participants", 8, "--seed", 1, "--out", root)
    for command in ("validate", "replay"):
        output(capsys, command, root)
    said = [row["response"] for row in trial_rows(root) if row["item"] == "age_years"]
    assert "" in said
    assert all(18 <= float(years) <= 99 for years in said if years)
    assert set(analyse(root).table("categories")["item"]) == set(ITEMS)


@pytest.mark.parametrize(("low", "high"), [(-1, 99), (99, 18), (0, "inf"), ("nan", 1), (0, 1e10)])
def test_untypable_number_is_refused(study, tmp_path, capsys, low, high):
    study.write_text(ALLOWED + YEARS.replace("= 18", f"= {low}").replace("= 99", f"= {high}"), "utf-8")
    said = refused(capsys, "simulate", study, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert "items[1].low: found " in said
    assert "expected a number from 0 on, below high, and high at most 999999999" in said


def test_bounds_without_whole_number_are_answered(study, tmp_path, capsys):
    study.write_text(ALLOWED + YEARS.replace("= 18", "= 0.2").replace("= 99", "= 0.8"), "utf-8")
    output(capsys, "simulate", study, "--participants", 4, "--seed", 1, "--out", tmp_path / "d")
    said = {row["response"] for row in trial_rows(tmp_path / "d") if row["item"] == "age_years"}
    assert "0.5" in said


def test_identifying_number_is_refused_without_permission(study, tmp_path, capsys):
    study.write_text(STUDY + YEARS, "utf-8")
    said = refused(capsys, "simulate", study, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert "inquiries.habits.identifies: found false with age_years in 'habits', expected true" in said


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("name", shipped_choices())
def test_shipped_questions_exist_in_every_language(name, language):
    assert language in load_choices(name).languages
    study = TUTORIAL + INQUIRY
    texts = texts_in(language, wire(parse(study.encode(), "s.toml"), "s.toml").words_in(language))
    for item in load_choices(name).items:
        question = f"{ABOUT}{name}.{item.id}"
        assert texts.message(question) == item.prompt[language]
        labels = [texts.label(f"{question}.{code}") for code in item.codes if code != NOT_SAID]
        assert labels == [option.words[language] for option in item.options]


def test_question_file_is_embedded_in_the_study(tmp_path, capsys):
    inquiry, _, form = OWN.partition("[forms.habits]\n")
    (tmp_path / "habits.toml").write_text(form.replace("[[forms.habits.items]]", "[[items]]"), "utf-8")
    (tmp_path / "s.toml").write_text(f'{TUTORIAL}\n{inquiry}[forms.habits]\npath = "habits.toml"\n', "utf-8")
    output(capsys, "simulate", tmp_path / "s.toml", "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    (tmp_path / "habits.toml").unlink()
    output(capsys, "replay", tmp_path / "d")
    assert "How often" in json.dumps(json.loads(output(capsys, "analyse", tmp_path / "d", "--json"))["categories"])


FLAWS = [
    ('form = "demographics"\nafter = "start"', 'form = "demographics"', "inquiries.about.after: found 'session' with"),
    ('form = "habits"', 'form = "habits"\nprompt = "Well?"', "inquiries.habits.prompt: found 'Well?', expected no"),
    ('form = "habits"', 'form = "habit"', "inquiries.habits.form: found 'habit', expected one of"),
    ("code = 2, words", "code = 1, words", "forms.habits: items[0].options[1].code: found 1, expected a whole number"),
    ("code = 2, words", "code = 0, words", "forms.habits: items[0].options[1].code: found 0, expected a whole number"),
    ("code = 2, words", "code = 1987, words", "options[1].code: found 1987, expected a whole number from 1 to 9"),
    ('fr = "moins souvent" } },\n]', 'fr = "moins souvent" } },\n]\nlow = 0', "low: found 0.0 with high None,"),
    ('form = "habits"', 'form = "habits"\nidentifies = true', "identifies: found true with no number in"),
    ('en = "less often"', 'en = " "', "forms.habits: items[0].options[1].words.en: found an empty text"),
    ('kind = "yes_no"', 'kind = "rating"\nform = "habits"', "task.form: found 'habits', a form of choices, expected"),
    ('kind = "yes_no"', 'kind = "rating"\nform = "demographics"', "task.form: found 'demographics', a form of choices"),
]


@pytest.mark.parametrize(("old", "new", "message"), FLAWS)
def test_flawed_question_is_refused_in_one_sentence(study, tmp_path, capsys, old, new, message):
    assert old in STUDY
    study.write_text(STUDY.replace(old, new), "utf-8")
    said = refused(capsys, "simulate", study, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert message in said
    assert not (tmp_path / "d").exists()


def test_excluded_participant_is_in_no_category(simulated):
    table = next((simulated / "data").glob("participant-P01_*.csv"))
    header, *rows = [line.split(",") for line in table.read_text("utf-8").splitlines()]
    task, valid = header.index("task"), header.index("valid")
    for row in rows:
        row[valid] = "0" if row[task] == "yes_no" else row[valid]
    table.write_text("".join(f"{','.join(row)}\n" for row in (header, *rows)), "utf-8")
    numbers = []
    for share in (1.0, 0.5):
        plan = AnalysisPlan(Exclusion(invalid_share_max=share), hierarchical=False)
        counted = analyse(simulated, plan=plan).tables["categories"]
        numbers.append(set(counted.groupby("item")["n"].sum()))
    assert numbers == [{4}, {3}]
