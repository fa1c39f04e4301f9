"""The command `tactometry keys`, errors that refer to it, and the page of commands."""

import json
import tomllib

import click
import pytest
from command_line import call, output, refused

from tactometry.cli import COMMANDS, reference, tactometry
from tactometry.experiments.reference.keys import keys_of
from tactometry.experiments.reference.tables import tables

PAGE = reference.PAGE.read_text(encoding="utf-8")
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
    key = {"name": "force_n", "holds": "a number", "unit": "N", "within": "above 0", "otherwise": "", "see": ""}
    means = "Force that the participant is asked to apply."
    assert table["keys"][1] == key | {"means": means, "example": "1.0", "required": True}
    assert table["example"].startswith('[touch]\nkind = "press"\nforce_n = 1.0\n')


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
    assert output(capsys, "keys", "touch").split() == ["touch.press", "touch.slide"]
    subtables = json.loads(output(capsys, "keys", "bench.force", "--json"))
    assert [table["name"] for table in subtables] == ["bench.force", "bench.force.calibration"]


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
    expected = "STUDY: found none, expected the name of a study; list them with tactometry new --list"
    assert refused(capsys, "new") == f"tactometry: {expected}"


WRONG = {
    "bench.toml": ('[output]\nkind = "file"\nfoldr = "played"\n', ["check", "--bench"], "bench.output.file"),
    "part.toml": ("[screens]\n", ["check", "--bench"], "bench"),
    "scene.toml": (
        "outputs = ['t_s']\nsurface = { kind = 'electrovibration' }\n",
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


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_page_lists_every_option(name):
    command = tactometry.get_command(click.Context(tactometry), name)
    section = PAGE.partition(f"## `tactometry {name}`\n")[2].partition("\n## ")[0]
    options = [one for one in command.params if isinstance(one, click.Option)]
    assert section
    assert [one.opts[-1] for one in options if one.opts[-1] not in section] == []


def test_commands_page_is_up_to_date():
    assert reference.text() == PAGE, "run make keys"
    assert "## `tactometry calibrate gain`" in PAGE
