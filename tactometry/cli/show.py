"""`tactometry show`: plot one trial."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .output import bench_option, data_argument, figure_option, say, subcommand, writing

if TYPE_CHECKING:
    from tactometry.experiments.data_sets.traces import TouchTrace


@subcommand("show data --trial 17 --participant P01")
@data_argument
@click.option("--trial", type=click.IntRange(min=1), required=True, help="Number of the trial in the session.")
@click.option("--participant", metavar="ID", help="Participant, if the data set has several.")
@click.option("--session", type=click.IntRange(min=1), help="Session, if the participant has several.")
@bench_option
@figure_option("PNG, PDF or SVG to write; default: trial-17.png in the working directory.")
def command(
    path: Path, trial: int, participant: str | None, session: int | None, bench_path: Path | None, figure: Path | None
) -> None:
    """Plot the touches of one trial of the data set PATH.

    The figure shows force, position and speed of the finger, and the emitted signal. The bench file is needed for
    signals of learnt responses and of a one-bit board.
    """
    from tactometry.experiments.data_sets.figures import heading, touch_figure
    from tactometry.experiments.data_sets.traces import read_traces

    touches = read_traces(path, trial, participant=participant, session=session, bench=bench_path)
    drawn = (figure or Path(f"trial-{trial}.png")) if touches else None
    if drawn is not None:
        with writing(drawn):
            drawing = touch_figure(touches)
            drawn.parent.mkdir(parents=True, exist_ok=True)
            match drawn.suffix:
                case ".svg":
                    drawn.write_text(drawing.svg, encoding="utf-8")
                case ".png":
                    drawn.write_bytes(drawing.png())
                case _:
                    drawing.figure.savefig(drawn, metadata={"CreationDate": None, "Subject": drawing.about})
    records = [{"touch": heading(touch), **_record(touch)} for touch in touches]
    last_line = f"figure: {drawn}" if drawn else f"trial {trial}: it has no touch"
    whose = {name: getattr(touch.head, name) for touch in touches[:1] for name in ("participant", "session")}
    lines = [
        ", ".join(f"{name} {value}" for name, value in whose.items()),
        *("\n".join(_text(record)) for record in records),
    ]
    say(
        "\n".join([*filter(None, lines), last_line]),
        {"trial": trial, **whose, "touches": records, "figure": drawn and str(drawn)},
    )


def _record(touch: "TouchTrace") -> dict[str, Any]:
    answer, emitted = touch.answer, touch.emitted
    names = ("gate_s", "invalid_reason", "force_mean_n", "force_in_band", "speed_mean_m_per_s", "n_gaps")
    known = {name: value for name in names if (value := getattr(answer, name, None)) is not None}
    samples = {"force": touch.force, "position": touch.position}
    return {
        "block": touch.trial.block,
        "attempt": touch.trial.attempt,
        "onset_s": answer.onset_s,
        "valid": touch.trial.valid and getattr(answer, "valid", True),
        **known,
        **{f"n_samples_{name}": len(kept.times_s) for name, kept in samples.items() if kept is not None},
        "emitted": repr(emitted) if emitted is not None else touch.unknown and f"unknown: {touch.unknown}",
        "files": [f"{part.file}, byte {part.first_byte} to {part.first_byte + part.n_bytes}" for part in answer.trace],
    }


def _text(record: dict[str, Any]) -> Iterator[str]:
    yield " - ".join(record["touch"].splitlines())
    for name, value in record.items():
        if name not in ("touch", "files") and value is not None:
            yield f"  {name:<20}{value}"
    yield from (f"  {file}" for file in record["files"])
