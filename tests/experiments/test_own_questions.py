"""Custom questions, and the docs' questionnaire file in all commands."""

import io
import re
import shutil

import pytest
from command_line import call, output, refused
from places import DOCS
from study_texts import TUTORIAL
from tables import trial_rows

from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load

PAGE = (DOCS / "reference" / "studies.md").read_text("utf-8")
SECTION = PAGE.partition("### Custom questionnaires and questions")[2].partition("\n## ")[0]
TABLES, FORM = re.findall(r"```toml\n(.*?)```", SECTION, re.S)
STUDY = TUTORIAL.replace('[task]\nkind = "yes_no"\n', TABLES.partition("\n[inquiries")[0]).replace(
    "[procedure]", f"[inquiries{TABLES.partition('[inquiries')[2]}\n[procedure]"
)


@pytest.fixture
def own(tmp_path):
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "roughness.toml").write_text(FORM, "utf-8")
    (tmp_path / "studies" / "own.toml").write_text(STUDY, "utf-8")
    return tmp_path / "studies" / "own.toml"


def test_own_questionnaire_data_need_no_files(own, tmp_path, capsys):
    root = tmp_path / "d"
    output(capsys, "simulate", own, "--participants", 3, "--seed", 1, "--out", root)
    shutil.rmtree(own.parent)
    rows = [row for row in trial_rows(root) if row["procedure"] == "roughness"]
    assert {row["item"] for row in rows} == {"rough", "sticky"}
    assert {row["frequency_hz"] for row in rows} == {"60", "240"}
    for command in ("validate", "replay"):
        output(capsys, command, root)
    assert "Roughness" in output(capsys, "analyse", root)
    output(capsys, "export", root, "--to", "psychopy", "--out", tmp_path / "e")


def test_console_shows_prompts_of_study(own, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 40 + "5\n" * 100))
    run = ("run", own, "--participant", "P01", "--rig", "console", "--out", tmp_path / "d")
    _, _, said = call(capsys, *run)
    assert "Was there a buzz?" in said
    assert "Did you feel" not in said.partition("[trial 1]")[2]
    assert "The sheet that you have just touched was ..." in said


@pytest.mark.parametrize(("language", "asked"), [("fr", "Y avait-il un bourdonnement ?"), ("nl", "Was there a buzz?")])
def test_prompt_falls_back_to_english(own, language, asked):
    assert wire(load(str(own))[0], "own.toml").words_in(language)["felt"] == asked


def test_prompt_without_bench_language_is_refused(own, tmp_path, capsys):
    own.write_text(own.read_text("utf-8").replace('{ en = "Was there a buzz?", fr', "{ fr"), "utf-8")
    said = refused(capsys, "run", own, "--participant", "P01", "--rig", "console", "--out", tmp_path / "d")
    assert (
        f"{own}, task.prompt: found no words in 'en', expected one of fr, de; choose that language on the bench" in said
    )
    assert not (tmp_path / "d").exists()


def test_study_without_forms_keeps_its_bytes():
    assert load("hybrid-button")[1] == builtin()["hybrid-button"].read_bytes()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "roughness.toml: cannot be read"),
        ("low = ", "roughness.toml: found no valid TOML"),
        (f'name = "smoothness"\n{FORM}', "roughness.toml, name: found 'smoothness', expected 'roughness'"),
        (FORM.replace("steps", "stops"), "roughness.toml, stops: found an unknown key"),
        (FORM.replace('["smooth", "rough"]', '["smooth"]'), "roughness.toml, items[0].poles.en: found "),
    ],
)
def test_file_without_questionnaire_is_refused_by_name(own, tmp_path, capsys, content, message):
    form = own.parent / "roughness.toml"
    form.unlink() if content is None else form.write_text(content, "utf-8")
    said = refused(capsys, "simulate", own, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert message in said
    assert not (tmp_path / "d").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('path = "roughness.toml"', 'path = "roughness.toml"\nlow = 1.0', "forms.roughness.low: found an unknown key"),
        ('path = "roughness.toml"', "path = 3", "forms.roughness.path: found 3, expected a text with the name of a"),
        ('path = "roughness.toml"', 'path = " "', "forms.roughness.path: found ' ', no name, expected the path of a"),
        ('path = "roughness.toml"', 'path = ""', "forms.roughness.path: found '', no name, expected the path of a"),
        ('path = "roughness.toml"', 'path = "."', "forms.roughness.path: found '.', a folder, expected the path of"),
        ('prompt = "The sheet', 'prompt = " " # "The sheet', "inquiries.rough.prompt: found an empty text"),
    ],
)
def test_empty_form_table_is_refused(own, tmp_path, capsys, old, new, message):
    own.write_text(own.read_text("utf-8").replace(old, new), "utf-8")
    said = refused(capsys, "run", own, "--participant", "P01", "--dry-run", "--rig", "simulated")
    assert said.startswith(f"tactometry: {own}, ")
    assert message in said
