"""Erasure in data sets with links, whose targets stay and are listed."""

import shutil

import pytest
from command_line import refused
from places import RECORDED
from tables import contents

from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets.erasing import erase
from tactometry.records.data_set import Session, participants, sessions

OPTIONS = ("--participant", "P77", "--rig", "simulated", "--seed", "1", "--out")
SIMULATED = ("--participants", "1", "--seed", "1", "--resume", "--out")
DATA_SET = next(path for path in sorted(RECORDED.iterdir()) if path.is_dir())


@pytest.mark.parametrize("part", ["data", "journals"])
def test_a_linked_folder_of_the_set_is_refused_and_nothing_goes(tmp_path, part):
    root = with_link(tmp_path, DATA_SET, part)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InvalidFile, match=f"{part}: found a link, expected the folder itself"):
        erase(root, participants(root)[0])
    assert sorted(tmp_path.rglob("*")) == before


def with_link(tmp_path, data_set, part):
    """Copy a data set and replace one of its folders by a link."""
    root, elsewhere = shutil.copytree(data_set, tmp_path / "d"), tmp_path / "elsewhere"
    (root / part).mkdir(exist_ok=True)
    (root / part).rename(elsewhere)
    (root / part).symlink_to(elsewhere)
    return root


@pytest.mark.parametrize("part", ["data", "journals", "traces"])
@pytest.mark.parametrize("words", [("rebuild",), ("run", "tutorial", *OPTIONS), ("simulate", "tutorial", *SIMULATED)])
def test_linked_folder_is_not_written_through(tmp_path, capsys, part, words):
    root = with_link(tmp_path, RECORDED / "format-2-simulated", part)
    before = contents(tmp_path)
    said = refused(capsys, *words, root)
    assert f"{part}: found a link, expected the folder itself" in said
    assert contents(tmp_path) == before


def test_linked_interruptions_are_not_written_through(tmp_path, capsys):
    root = shutil.copytree(RECORDED / "format-2-simulated", tmp_path / "d")
    journal, outside = sessions(root)[0], tmp_path / "outside"
    outside.write_text("mine")
    journal.with_name(f"{journal.stem}_interruptions.jsonl").symlink_to(outside)
    with journal.open("ab") as file:
        file.write(b"torn")
    assert "_interruptions.jsonl: found a link, expected a file" in refused(capsys, "rebuild", root)
    assert outside.read_text() == "mine"


def test_broken_link_in_place_of_folder_is_refused(tmp_path, capsys):
    root = shutil.copytree(RECORDED / "format-2-simulated", tmp_path / "d")
    shutil.rmtree(root / "data")
    (root / "data").symlink_to(tmp_path / "gone")
    assert "data: found a link, expected the folder itself" in refused(capsys, "rebuild", root)
    assert not (tmp_path / "gone").exists()


@pytest.mark.parametrize("folder", ["data", "journals"])
@pytest.mark.parametrize("end", ["missing", "absent/missing"])
def test_a_link_to_what_is_not_there_now_goes_and_is_told(tmp_path, folder, end):
    """The target may be on a disk that is not connected."""
    root = shutil.copytree(DATA_SET, tmp_path / "d")
    code = participants(root)[0]
    link = Session(code, 9, "link").journal(root) if folder == "journals" else Session(code, 9, "link").trials(root)
    link.symlink_to(tmp_path / end)
    done = erase(root, code)
    assert not link.is_symlink()
    assert done.others == (f"{folder}/{link.name} -> {tmp_path / end}",)
    assert not (tmp_path / end).exists()


def test_circular_link_is_erased(tmp_path):
    root = shutil.copytree(DATA_SET, tmp_path / "d")
    code = participants(root)[0]
    link = Session(code, 9, "link").trials(root)
    link.symlink_to(link)
    erase(root, code)
    assert not link.is_symlink()
