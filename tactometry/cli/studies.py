"""`tactometry studies` and `tactometry new`."""

from pathlib import Path

import click

from ..errors import DeviceFailed, InvalidFile, InvalidParameter
from .output import STUDY, path_option, say, subcommand


@subcommand("studies")
def studies() -> None:
    """List the built-in studies."""
    _say_studies()


def _say_studies() -> None:
    from tactometry.experiments.study.study_file import load, shipped

    titles = {name: load(name)[0].title for name in shipped()}
    width = max(map(len, titles))
    say("\n".join(f"{name:<{width}}  {title}" for name, title in titles.items()), titles)


@subcommand("new tutorial --out mine.toml")
@click.argument("study", type=STUDY, required=False)
@path_option("--out", help="File to write, - for standard output; default: STUDY.toml.")
@click.option("--list", "is_list", is_flag=True, help="List the built-in studies, as tactometry studies does.")
def new(study: str | None, out: Path | None, *, is_list: bool) -> None:
    """Copy the built-in STUDY to a file to edit."""
    from tactometry.experiments.study.study_file import load, locate

    if is_list:
        _say_studies()
        return
    if study is None:
        raise InvalidParameter("STUDY: found none, expected the name of a study; list them with tactometry new --list")
    _, content = load(study)
    if out == Path("-"):
        click.echo(content, nl=False)
        return
    path = out or Path(locate(study).name)
    try:
        with path.open("xb") as file:
            file.write(content)
    except FileExistsError:
        raise InvalidFile(f"{path}: found an existing file, expected a new file; choose another --out") from None
    except (FileNotFoundError, NotADirectoryError):
        raise InvalidFile(f"{path}: found no folder {path.parent}, expected this folder; create it first") from None
    except OSError as error:
        raise DeviceFailed(f"{path}: cannot write ({error.strerror}), expected a writable folder") from None
    say(f"wrote {path}; run it with: tactometry run {path} --participant P01", {"file": str(path)})
