"""Links in a data set: what they lead to stays and is told; behind a folder that is one nothing would be erased."""

import shutil

import pytest
from places import RECORDED

from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets.erasing import erase
from tactometry.records.data_set import Session, participants

DATA_SET = next(path for path in sorted(RECORDED.iterdir()) if path.is_dir())


@pytest.mark.parametrize("part", ["data", "journals"])
def test_a_linked_folder_of_the_set_is_refused_and_nothing_goes(tmp_path, part):
    root, elsewhere = shutil.copytree(DATA_SET, tmp_path / "d"), tmp_path / "elsewhere"
    (root / part).rename(elsewhere)
    (root / part).symlink_to(elsewhere)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InvalidFile, match=f"{part}: found a link, expected the folder itself"):
        erase(root, participants(root)[0])
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("folder", ["data", "journals"])
@pytest.mark.parametrize("end", ["missing", "absent/missing"])
def test_a_link_to_what_is_not_there_now_goes_and_is_told(tmp_path, folder, end):
    """It may lead to a disk that is put in again: nothing is made there."""
    root = shutil.copytree(DATA_SET, tmp_path / "d")
    code = participants(root)[0]
    link = Session(code, 9, "link").journal(root) if folder == "journals" else Session(code, 9, "link").trials(root)
    link.symlink_to(tmp_path / end)
    done = erase(root, code)
    assert not link.is_symlink()
    assert [(left.file, left.names) for left in done.left] == [(f"{folder}/{link.name}", True)]
    assert str(tmp_path / end) in done.left[0].why
    assert not (tmp_path / end).exists()


def test_a_link_that_leads_to_itself_goes(tmp_path):
    root = shutil.copytree(DATA_SET, tmp_path / "d")
    code = participants(root)[0]
    link = Session(code, 9, "link").trials(root)
    link.symlink_to(link)
    erase(root, code)
    assert not link.is_symlink()
