"""Figures 5.9 to 5.13 and of appendix A: the patterns on the AttrakDiff, as simulated participants fill it in."""

from collections.abc import Callable
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

from ..reproduction import Reproduction
from .studies import simulated_trials

if TYPE_CHECKING:
    from tactometry.analysis.outcomes.ratings import Ratings

STUDY, N_PARTICIPANTS = "time-reversal-patterns", 10
ASSUMES = (
    f"{N_PARTICIPANTS} simulated participants of the built-in study {STUDY} with seed 1, and its form: the thesis's "
    "items were inspired by the AttrakDiff, which ones is not in our sources. One rating model, an inverted U of the "
    "sensation level (unverified), answers each item: word pairs of a pattern differ by chance alone."
)


@lru_cache(maxsize=1)
def answers() -> "Ratings":
    """What the simulated participants said of the patterns."""
    from tactometry.analysis.outcomes.ratings import ratings

    [form] = ratings(simulated_trials(STUDY, N_PARTICIPANTS))
    return form


def _word_pairs(*patterns: str) -> Any:
    return _profile(answers().profile, patterns)


def _grouped(of: str) -> Any:
    """The mean over the patterns of one frequency, or of one envelope, beside the single focus."""
    grouped = answers().grouped
    assert grouped is not None, "the built-in study rates all patterns"
    profile = grouped[grouped["of"] == of]
    return _profile(profile, tuple(dict.fromkeys(profile["condition"])))


def _profile(profile: Any, names: tuple[str, ...]) -> Any:
    from tactometry.analysis.figures.attrakdiff import profile_figure

    form = answers().form
    return profile_figure(profile, names, form.score_low, form.score_high).figure


def _figure(title: str, number: str, drawing: Callable[[], Any], stated: str = "") -> Reproduction:
    page = 13 if number.startswith("5") else 14
    said = f"The caption of Figure {number} (page {page}){f'; {stated}' if stated else ''}. Not the scores."
    return Reproduction(title=title, stated=said, assumes=ASSUMES, drawing=drawing, origin="assumed")


def _of_pattern(n: int) -> Reproduction:
    return _figure(f"Pattern P{n} by word pairs", f"A.{n + 1}", partial(_word_pairs, f"P{n}"))


FIGURE_5_9 = _figure(
    "The single focus by word pairs", "5.9", partial(_word_pairs, "P0"), "brief, not pleasant (page 4)"
)
FIGURE_5_10 = _figure("P0 to P3 by word pairs", "5.10", partial(_word_pairs, "P0", "P1", "P2", "P3"))
FIGURE_5_11 = _figure("P0 and P4 to P6 by word pairs", "5.11", partial(_word_pairs, "P0", "P4", "P5", "P6"))
FIGURE_5_12 = _figure(
    "Low and high frequency by word pairs", "5.12", partial(_grouped, "frequency"), "200 Hz pleases most (page 4)"
)
FIGURE_5_13 = _figure(
    "Envelopes by word pairs", "5.13", partial(_grouped, "envelope"), "a cardinal sine pleases most (page 4)"
)
FIGURE_A_1 = _of_pattern(0)
FIGURE_A_2 = _of_pattern(1)
FIGURE_A_3 = _of_pattern(2)
FIGURE_A_4 = _of_pattern(3)
FIGURE_A_5 = _of_pattern(4)
FIGURE_A_6 = _of_pattern(5)
FIGURE_A_7 = _of_pattern(6)
