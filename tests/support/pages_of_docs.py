"""The code blocks of a page of the docs, which the tests run as they stand."""

import re

from places import DOCS


def blocks(page, language):
    """Those of a language, in their order."""
    return re.findall(
        rf"^```{language}\n(.*?)^```$", (DOCS / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
