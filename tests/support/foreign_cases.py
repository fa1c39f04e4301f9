"""Tables with faults that people reported of other programs, written from counts of answers."""

import csv
import io
import json
from pathlib import Path

YES_NO = {"S01": (1, 1, 7, 12, 11), "S02": (0, 0, 6, 11, 12), "S03": (1, 0, 4, 11, 12), "S04": (1, 2, 6, 12, 12)}
"""Positive answers of 12 at the levels 2 to 10; the true threshold is 6."""
NEGATIVE = {"S01": (1, 0, 5, 13, 14), "S02": (1, 2, 6, 12, 14), "S03": (0, 3, 8, 11, 14)}
"""Positive answers of 14 at the levels -12 to 0."""
CORRECT = {
    2: (
        (11, 12, 12, 14, 20, 19),
        (9, 11, 14, 18, 20, 19),
        (6, 8, 15, 19, 18, 19),
        (15, 9, 13, 18, 19, 20),
        (8, 10, 13, 17, 19, 18),
        (8, 11, 18, 18, 19, 20),
    ),
    4: (
        (7, 9, 11, 12, 19, 19),
        (8, 6, 12, 13, 19, 20),
        (4, 7, 10, 15, 17, 19),
        (5, 4, 11, 15, 19, 19),
        (4, 6, 11, 14, 18, 19),
        (6, 4, 14, 17, 19, 20),
    ),
}
"""Correct answers of 20 at the levels 1 to 6, by the number of alternatives, of six participants."""
MAP = '[constants]\ntask = "yes_no"\n[values.response]\ny = 1\nn = 0\n'
BIDS = """missing = ["n/a"]
columns = { latency_s = "rt" }
constants = { task = "yes_no" }
from_name = { participant = "sub" }
values = { response = { yes = 1, no = 0 } }
"""
PSYCHOPY = 'columns = { response = "key_resp.keys", latency_s = "key_resp.rt" }\n' + MAP
TASK = '[constants]\ntask = "yes_no"\n'
COUNTS = '[columns]\nn_positive = "n_yes"\nn_trials = "n_total"\n'
HEAD = ("participant", "level", "response")
TRIALS = [
    (code, level, "y" if n < k else "n")
    for code, positive in YES_NO.items()
    for level, k in zip(range(2, 12, 2), positive, strict=True)
    for n in range(12)
]
NEGATIVE_TRIALS = [
    (code, level, int(n < k))
    for code, positive in NEGATIVE.items()
    for level, k in zip(range(-12, 3, 3), positive, strict=True)
    for n in range(14)
]


def table(rows, head=HEAD, *, separator=",", end="\n"):
    return "".join(separator.join(map(str, row)) + end for row in (head, *rows))


def quoted(rows, head=HEAD):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([head, *rows])
    return text.getvalue()


def objects(rows):
    return json.dumps([dict(zip(HEAD, row, strict=True)) for row in rows])


def of(code, rows=TRIALS):
    return [row for row in rows if row[0] == code]


def noted(opened):
    """Return rows with notes that begin with a quotation mark, before the rows of these numbers."""
    notes = dict.fromkeys((20, 55, 80, 110), opened)
    return [(code, notes.get(n, "ok"), *rest) for n, (code, *rest) in enumerate(TRIALS)]


def by_name(form):
    """Return a table for each participant, whose name has the code in this form."""
    return {form.format(code): table([row[1:] for row in of(code)], HEAD[1:]) for code in YES_NO}


def psychopy(with_latency):
    """Return tables of a key response, with and without its latency."""
    files = {}
    for number, code in enumerate(NEGATIVE, 1):
        rows = [
            (code, level, "ny"[answer], *([0.51] * (number in with_latency)), "")
            for _, level, answer in of(code, NEGATIVE_TRIALS)
        ]
        latency = ["key_resp.rt"] * (number in with_latency)
        files[f"{number}.csv"] = table(rows, ["participant", "level", "key_resp.keys", *latency, ""])
    return files


def bids():
    """Return a BIDS data set with a byte-order mark, CR LF and a participant who is listed twice."""
    files = {"participants.tsv": "\ufeffparticipant_id\tage\nsub-01\t30\nsub-01\t31\nsub-02\t28\n"}
    files["dataset_description.json"] = '{"Name": "x", "BIDSVersion": "1.9.0"}'
    for code in YES_NO:
        name = f"sub-{code[1:]}"
        rows = [(level, {"y": "yes", "n": "no"}[answer], "n/a") for _, level, answer in of(code)]
        head = ("level", "response", "rt")
        files[f"{name}/beh/{name}_task-detect_beh.tsv"] = "\ufeff" + table(rows, head, separator="\t", end="\r\n")
    return files


def alternatives():
    rows = [
        (f"S0{number}", level, target, target if n < k else target % m + 1, m)
        for m, participants in CORRECT.items()
        for number, counts in enumerate(participants, 1)
        for level, k in enumerate(counts, 1)
        for n in range(20)
        for target in (n % m + 1,)
    ]
    return table(rows, ("participant", "level", "target", "response", "n_afc"))


def without_zeros():
    """Return trials whose later levels have participant codes without the leading zero."""
    rows = [(code[1:], level, answer) for code, level, answer in TRIALS]
    return [(code if level <= 4 else code.lstrip("0"), level, answer) for code, level, answer in rows]


COUNTED = [
    (code, level, k, 12)
    for code, positive in YES_NO.items()
    for level, k in zip(range(2, 12, 2), positive, strict=True)
]
ROWS_IN_R = [(f'"{n}"', f'"{code}"', level, f'"{answer}"') for n, (code, level, answer) in enumerate(TRIALS, 1)]
CASES = {
    "plain": (MAP, {"t.csv": table(TRIALS)}),
    "open_quotation_mark": (MAP, {"t.csv": table(noted('"too fast'), ("participant", "note", "level", "response"))}),
    "line_in_a_cell": (MAP, {"t.csv": quoted(noted("one\ntwo, three"), ("participant", "note", "level", "response"))}),
    "csv_beside_json": (
        MAP,
        {"d/S03.json": objects(of("S03")), **{f"d/{code}.csv": table(of(code)) for code in ("S01", "S02", "S04")}},
    ),
    "alternatives": ('[constants]\ntask = "forced_choice"\n', {"t.csv": alternatives()}),
    "leading_zeros": (MAP, {"t.csv": table(without_zeros())}),
    "counts": (TASK + COUNTS, {"t.csv": table(COUNTED, ("participant", "level", "n_yes", "n_total"))}),
    "unmapped_counts": (TASK, {"t.csv": table(COUNTED, ("participant", "level", "n_yes", "n_total"))}),
    "code_in_name": (MAP + '[from_name]\nparticipant = "*"\n', {f"d/{k}": v for k, v in by_name("{}.csv").items()}),
    "code_within_name": (
        MAP + '[from_name]\nparticipant = "_subject_*_"\n',
        {f"d/{k}": v for k, v in by_name("_subject_{}_data_2026-03-01_10.00.csv").items()},
    ),
    "key_not_in_name": (MAP + '[from_name]\nparticipant = "P"\n', {f"d/{k}": v for k, v in by_name("{}.csv").items()}),
    "missing_latency": (PSYCHOPY, {f"d/{k}": v for k, v in psychopy((1, 2)).items()}),
    "row_numbers_of_r": (MAP, {"t.csv": table(ROWS_IN_R, ('""', '"participant"', '"level"', '"response"'))}),
    "row_numbers_of_pandas": (MAP, {"t.csv": table([(n, *row) for n, row in enumerate(TRIALS)], ("", *HEAD))}),
    "sep_line": (MAP, {"t.csv": "sep=,\n" + table(TRIALS)}),
    "unicode_minus": (TASK, {"t.csv": table(NEGATIVE_TRIALS).replace("-", "\u2212")}),
    "one_line": (MAP, {"t.csv": table(TRIALS, end=",")}),
    "json_as_txt": (MAP, {"t.txt": "\n".join(objects(of(code)) for code in YES_NO)}),
    "folder_of_json_as_txt": (MAP, {f"d/results_{code}.txt": objects(of(code)) for code in YES_NO}),
    "workbook": (MAP, {"t.xlsx": "PK\x03\x04 xl/worksheets/sheet1.xml"}),
    "column_twice": (MAP, {"t.csv": table([(*row, "a", "b") for row in TRIALS], (*HEAD, "note", "note"))}),
    "carriage_returns": (MAP, {"t.csv": table(TRIALS, end="\r")}),
    "bids": (BIDS, {f"d/{name}": text for name, text in bids().items()}),
}
"""The column map and the files of each case: one table t, or the folder d."""


def write_case(name, folder: Path):
    """Write a case into a folder, and return the path to analyse."""
    column_map, files = CASES[name]
    (folder / "map.toml").write_text(column_map)
    for file, text in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_bytes(text.encode())
    first = next(iter(files))
    return folder / first.split("/")[0]
