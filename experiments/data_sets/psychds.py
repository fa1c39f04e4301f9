"""A data set in the form of Psych-DS alone, to be shared: tables and what their columns mean, without journals.

A recorded data set is Psych-DS already; here also a single table becomes one, and names use the official keywords only.
"""

from collections.abc import Mapping

from tactometry.files.safe_text import cell_text
from tactometry.records.description import KEYWORD

from .source import ExportedDataSet, delimited_text, json_text

SCHEMA_VERSION = "Psych-DS 1.5.0"


def psychds_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Every file, by its path; the same data give the same bytes."""
    names = [column.name for column in source.columns]
    study = (source.text("study") or "trials").replace("-", "")  # a hyphen parts key and value in names of files
    files = {
        "dataset_description.json": json_text(_description(source)),
        "README.md": f"# {source.title}\n\n{source.description}\n\nWritten by tactometry export.\n".encode(),
        "CHANGES.md": b"# Changes\n\n1.0.0: as exported.\n",
    }
    for participant, session, rows in source.sessions():
        body = [[row.get(name, "") for name in names] for row in rows]
        stem = f"subject-{participant}_session-{session}_study-{study}"
        files[f"data/{stem}_data.csv"] = delimited_text(names, body, ",")
    return files


def _description(source: ExportedDataSet) -> Mapping[str, object]:
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": source.title,
        "description": source.description,
        "schemaVersion": SCHEMA_VERSION,
        **({"keywords": [KEYWORD]} if source.origin.is_simulated else {}),
        "variableMeasured": [
            {"@type": "PropertyValue", "name": cell_text(column.name), "description": column.description}
            | ({"unitText": column.unit} if column.unit else {})
            for column in source.columns
        ],
    }
