"""A page printed to PDF by what is installed: a browser, else WeasyPrint."""

import shutil
import subprocess
import tempfile
from pathlib import Path

from tactometry.errors import DeviceFailed

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
WEASYPRINT = "weasyprint"
PDF_TIMEOUT_S = 120.0


def print_pdf(path: Path) -> Path:
    """Print the page to a PDF beside it.

    Raises
    ------
    DeviceFailed
        If there is neither browser nor WeasyPrint, or it fails.
    """
    engine = next(filter(None, map(shutil.which, (*BROWSERS, WEASYPRINT))), None)
    if engine is None:
        raise DeviceFailed(
            f"--pdf: found neither a browser ({', '.join(BROWSERS)}) nor {WEASYPRINT}, expected one; print {path} by "
            "hand"
        )
    target = path.with_suffix(".pdf").resolve()
    target.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as profile:
        command = _command(engine, path, target, profile)
        try:
            done = subprocess.run(command, capture_output=True, timeout=PDF_TIMEOUT_S, check=False)
        except subprocess.TimeoutExpired:
            raise DeviceFailed(f"--pdf: {engine} did not end in {PDF_TIMEOUT_S:g} s; print {path} by hand") from None
    if done.returncode != 0 or not target.exists():
        raise DeviceFailed(f"--pdf: {engine} ended with status {done.returncode}; print {path} by hand")
    return target


def _command(engine: str, path: Path, target: Path, profile: str) -> list[str]:
    if Path(engine).name == WEASYPRINT:
        return [engine, str(path.resolve()), str(target)]
    return [
        engine,
        *("--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={profile}"),
        f"--print-to-pdf={target}",
        path.resolve().as_uri(),
    ]
