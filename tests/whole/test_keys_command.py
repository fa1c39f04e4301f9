"""The command `tactometry keys`, and errors that refer to it."""

import json
import subprocess
import sys
import tomllib

import pytest
from command_line import call, output, refused

from tactometry.experiments.reference.keys import keys_of
from tactometry.experiments.reference.tables import tables

NAMES = ("procedure.staircase", "stimulus.focus", "touch.slide", "bench.output", "map", "scene.contacts", "study")


@pytest.mark.parametrize("name", NAMES)
def test_keys_lists_each_key_within_80_columns(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    said = output(capsys, "keys", name)
    assert said.startswith(f"{name}: ")
    assert [key.name for key in keys_of(tables()[name]) if key.name not in said] == []
    assert max(map(len, said.splitlines())) <= 80


def test_keys_prints_the_same_as_json(capsys):
    [table] = json.loads(output(capsys, "keys", "touch.press", "--json"))
    assert (table["name"], table["table"]) == ("touch.press", "[touch]")
    assert table["keys"][1] == {
        "name": "force_n",
        "holds": "a number",
        "unit": "N",
        "within": "above 0",
        "otherwise": "",
        "means": "Force that the participant is asked to apply.",
        "example": "1.0",
        "see": "",
        "required": True,
    }
    assert table["example"].startswith('[touch]\nkind = "press"\nforce_n = 1.0\n')


def test_keys_lists_a_table_with_its_subtables(capsys):
    told = json.loads(output(capsys, "keys", "bench.force", "--json"))
    assert [table["name"] for table in told] == ["bench.force", "bench.force.calibration"]


def test_keys_texts_lists_every_shipped_text(capsys):
    listed = tomllib.loads(output(capsys, "keys", "texts"))
    assert listed == json.loads(output(capsys, "keys", "texts", "--json"))
    assert listed["yes"] == "yes"
    assert "{stop}" in listed["welcome"]


def test_without_a_name_every_name_is_listed(capsys):
    assert json.loads(output(capsys, "keys", "--json")) == list(tables())
    lines = output(capsys, "keys").splitlines()
    assert "touch       press slide" in lines
    assert max(map(len, lines)) <= 80


def test_the_beginning_of_names_lists_them(capsys):
    assert output(capsys, "keys", "touch").split() == ["touch.press", "touch.slide"]


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("touch.slied", "touch.slide"),
        ("scene.finger", "scene.effects.finger_load"),
        ("", "a name listed by tactometry keys"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest(name, near, capsys):
    said = refused(capsys, "keys", name)
    assert said.startswith(f"tactometry: NAME: found {name!r}, expected ")
    assert near in said


def test_new_lists_the_built_in_studies(capsys):
    assert output(capsys, "new", "--list") == output(capsys, "studies")
    assert (
        refused(capsys, "new")
        == "tactometry: STUDY: found none, expected the name of a study; list them with tactometry new --list"
    )


WRONG = {
    "bench.toml": ('[output]\nkind = "file"\nfoldr = "played"\n', ["check", "--bench"], "bench.output.file"),
    "part.toml": ("[screens]\n", ["check", "--bench"], "bench"),
    "scene.toml": (
        'outputs = ["t_s"]\nsurface = { kind = "electrovibration" }\n',
        ["scene"],
        "scene.surface.electrovibration",
    ),
    "plate.toml": ("length_m = 1.0\n", ["design", "--plate"], "plate"),
    "study.toml": ("[touch]\n", ["run", "--participant", "P01", "--dry-run"], "study"),
}


@pytest.mark.parametrize("file", WRONG)
def test_refused_key_names_the_keys_command(file, capsys, tmp_path, monkeypatch):
    text, command, name = WRONG[file]
    monkeypatch.chdir(tmp_path)
    (tmp_path / file).write_text(text, encoding="utf-8")
    code, said, _ = call(capsys, *command, file)
    assert code == 2
    assert all(line.endswith(f" (all keys: tactometry keys {name})") for line in said.splitlines())


def test_keys_imports_only_what_a_name_needs():
    """None of the libraries of sessions, analyses or figures is loaded."""
    code = (
        "import sys\nfrom tactometry.cli import main\ntry:\n    main(['keys', 'touch.slide'])\n"
        "except SystemExit:\n    print(sorted({'scipy', 'pandas', 'matplotlib', 'numba'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


EXPLAINED = [
    name
    for name in tables()
    if name.partition(".")[0] in ("task", "procedure", "practice", "plate") or name == "observer.people"
]


@pytest.mark.parametrize("name", EXPLAINED)
def test_keys_explains_each_key_differently(name, capsys):
    for table in json.loads(output(capsys, "keys", name, "--json")):
        told = [key["means"] for key in table["keys"]]
        assert all(len(text.split()) > 3 for text in told)
        assert len(set(told)) == len(told)
