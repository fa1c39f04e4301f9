"""A folder of a data set that is a link: behind it nothing would be erased, so that nothing is."""

import shutil

import pytest
from places import RECORDED

from tactometry.errors import InvalidFile
from tactometry.experiments.data_sets.erasing import erase
from tactometry.records.data_set import participants

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
