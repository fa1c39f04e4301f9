"""The page of commands is what the commands say of themselves."""

import click
import pytest

from tactometry.cli import COMMANDS, reference, tactometry

PAGE = reference.PAGE.read_text(encoding="utf-8")


def test_the_page_is_as_it_would_be_written():
    assert reference.text() == PAGE, "run make keys"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_a_command_is_on_the_page(name):
    command = tactometry.get_command(click.Context(tactometry), name)
    section = PAGE.partition(f"## `tactometry {name}`\n")[2].partition("\n## ")[0]
    options = [one for one in command.params if isinstance(one, click.Option)]
    assert section
    assert [one.opts[-1] for one in options if one.opts[-1] not in section] == []


def test_a_command_of_a_group_has_a_section_of_its_own():
    assert "## `tactometry calibrate gain`" in PAGE
