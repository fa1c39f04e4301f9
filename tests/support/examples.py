"""How many examples a law takes whose every example is dear, or cheap."""

from math import ceil

from hypothesis import settings

FULL = settings.get_profile("reduced").max_examples


def examples(n, **more):
    """`n` of them, and in `make test` as small a share of that as other laws take of theirs."""
    share = min(1.0, settings.default.max_examples / FULL)
    return settings(max_examples=ceil(n * share), **more)
