"""Study files whose text is changed: shorter, faster, or on another bench."""

from tactometry.experiments.study.study_file import load


def changed(text, changes):
    """The text with all changes, none of which may miss what it replaces."""
    for old, new in changes.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


def tutorial_in(folder, changes):
    """A file with the tutorial, changed."""
    path = folder / "short.toml"
    path.write_text(changed(load("tutorial")[1].decode(), changes), encoding="utf-8")
    return path
