"""Reading of table files as decoded and normalised text."""

import re
import unicodedata
from pathlib import Path

from tactometry.errors import InvalidFile
from tactometry.files.durable import read_file

WORKBOOK = "an Excel workbook; save its sheet as CSV"
PICKLE = "a Python pickle such as PsychoPy's .psydat; use the CSV file, or save one with saveAsWideText"
UTF_16 = "UTF-16 text such as Excel's Unicode text; save the table as CSV in UTF-8"
SIGNATURES = (
    (b"PK\x03\x04", WORKBOOK),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook (.xls); save its sheet as CSV"),
    *((bytes((0x80, protocol)), PICKLE) for protocol in (2, 3, 4, 5)),
    (b"\x1f\x8b", "a compressed file; unpack it"),
    (b"MATLAB 5.0", "a MATLAB file; save the table as CSV (writetable)"),
    (b"\x89HDF", "an HDF5 or MATLAB 7.3 file; save the table as CSV"),
    (b"$FL", "an SPSS file; save the table as CSV"),
    (b"PAR1", "a Parquet file; save the table as CSV"),
    (b"\xff\xfe", UTF_16),
    (b"\xfe\xff", UTF_16),
)
"""First bytes of unsupported files, with the kind of file and how to export a text table."""
_INVISIBLE = re.compile("[\u200b\u200e\u200f\u2060\ufeff]")
_MINUS = re.compile("[\u2212\uff0d](?=[.,]?[0-9])")
_JSON_LIST = re.compile(r"\s*\[\s*[{\]]")


def file_text(file: Path, *, verbatim: bool = False) -> str:
    """Read UTF-8 text, normalised by `plain_text` unless `verbatim`.

    Raises `InvalidFile` if the file cannot be read, is empty, or is not UTF-8 text.
    """
    content = read_file(file, "a table of trials")
    kinds = [kind for signature, kind in SIGNATURES if content.startswith(signature)]
    kinds += [PICKLE] if file.suffix.lower() == ".psydat" else []
    if kinds:
        raise InvalidFile(f"{file}: found {_kind_of_archive(content, kinds[0])}")
    try:
        text = content.decode("utf-8-sig")  # spreadsheets write a byte order mark
    except UnicodeDecodeError as damage:
        row = content.count(b"\n", 0, damage.start) + 1
        raise InvalidFile(
            f"{file}, row {row}: found the byte 0x{content[damage.start]:02x}, expected UTF-8 text; save the table as "
            "UTF-8"
        ) from None
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        raise InvalidFile(f"{file}, row {row}: found a null byte, expected text")
    if not text.strip():
        raise InvalidFile(f"{file}: found an empty file, expected a header and trials")
    return text if verbatim else plain_text(text)


def _kind_of_archive(content: bytes, kind: str) -> str:
    """Distinguish a spreadsheet from another ZIP archive."""
    if kind != WORKBOOK or b"xl/" in content:
        return kind
    if b"opendocument" in content:
        return "an OpenDocument spreadsheet; save its sheet as CSV"
    return "a ZIP archive; unpack it and pass the folder"


def plain_text(text: str) -> str:
    r"""Normalise to NFC and ASCII minus signs, and remove invisible characters.

    >>> plain_text("\u221212\u200b"), plain_text("gro\u0308\u00dfe") == "gr\u00f6\u00dfe"
    ('-12', True)
    """
    return text if text.isascii() else _MINUS.sub("-", _INVISIBLE.sub("", unicodedata.normalize("NFC", text)))


def trimmed(text: str) -> str:
    """Trim a text, except one of spaces only, such as jsPsych's space bar.

    >>> trimmed(" S01 "), trimmed(" ")
    ('S01', ' ')
    """
    return text.strip() or text


def is_json_list(text: str) -> bool:
    """Return True if a text begins like a JSON list of objects.

    >>> is_json_list('[{"level": 2}]'), is_json_list("level,response"), is_json_list("[mm],answer")
    (True, False, False)
    """
    return _JSON_LIST.match(text) is not None
