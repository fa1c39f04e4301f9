"""The page of commands matches the commands' help."""

import click
import pytest

from tactometry.cli import COMMANDS, reference, tactometry

PAGE = reference.PAGE.read_text(encoding="utf-8")


def test_commands_page_is_up_to_date():
    assert reference.text() == PAGE, "run make keys"


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_page_lists_every_option(name):
    command = tactometry.get_command(click.Context(tactometry), name)
    section = PAGE.partition(f"## `tactometry {name}`\n")[2].partition("\n## ")[0]
    options = [one for one in command.params if isinstance(one, click.Option)]
    assert section
    assert [one.opts[-1] for one in options if one.opts[-1] not in section] == []


def test_grouped_command_has_own_section():
    assert "## `tactometry calibrate gain`" in PAGE
