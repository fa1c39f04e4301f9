"""Simulated answers to questionnaires."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp
from typing import Annotated

import numpy as np
from annotated_types import Interval

from ..arguments.constraints import Finite, NotNegative, constrained
from ..config.strict import LOST_LEVEL, check_keys
from ..session.request import Fill
from ..trials.cells import cell as cell_text
from .people import Draws

Factors = Mapping[str, float | str]
Loading = Annotated[float, Interval(ge=-1, le=1)]


@dataclass(frozen=True)
@constrained
class Raters:
    """Raters with attitudes from -1 (negative pole) to 1 (positive pole).

    These are the keys of `[observer.raters]`. For an item with loading l, whose positive
    pole is on the right (s = 1) or left (s = -1), the answer is ``extremity s (l attitude + noise z) + acquiescence``,
    with z standard normal: a common factor model (Bollen, Structural Equations with Latent Variables, 1989, chapter 7).
    An attitude is the sum of the stated effects, of `liking` times the liking of the stimulus strength, and of random
    deviations of the person: general, by dimension, and by dimension and stimulus. Sources: `raters` in
    `stimuli/sources.toml`.

    - `loading`: Loading of every item that is not in `loadings`.
    - `loadings`: Loading of single items, by the item's id.
    - `noise`: Standard deviation of the noise of an item.
    - `liking`: Weight of the liking of the stimulus strength, which the observer returns.
    - `attitude_sd`: Standard deviation between participants of their general attitude.
    - `dimension_sd`: Standard deviation between participants of their attitude to a dimension.
    - `stimulus_sd`: Standard deviation between participants of their attitude to a dimension of one stimulus.
    - `extremity_cv`: Spread between participants of the factor by which they use the scale, on a logarithmic scale.
    - `acquiescence_sd`: Standard deviation between participants of the shift of all their answers to the right.
    - `effects`: Effect of a level of a factor on the attitude of all participants, by factor, level and dimension.
    """

    loading: Loading = 0.8
    loadings: dict[str, Loading] = field(default_factory=dict)
    noise: NotNegative = 0.3
    liking: Finite = 0.3
    attitude_sd: NotNegative = 0.15
    dimension_sd: NotNegative = 0.15
    stimulus_sd: NotNegative = 0.2
    extremity_cv: NotNegative = 0.2
    acquiescence_sd: NotNegative = 0.1
    effects: dict[str, dict[str, dict[str, Finite]]] = field(default_factory=dict)

    def check(
        self, factors: Mapping[str, Sequence[float | str]], dimension_of: Mapping[str, Mapping[str, str]], path: str
    ) -> None:
        """Refuse unknown names of factors, levels, items and dimensions."""
        items = {item: name for of_form in dimension_of.values() for item, name in of_form.items()}
        check_keys(self.loadings, items, f"{path}.loadings", "item")
        check_keys(self.effects, factors, f"{path}.effects", "factor")
        dimensions = list(dict.fromkeys(items.values()))
        for name, of_factor in self.effects.items():
            check_keys(of_factor, list(map(cell_text, factors[name])), f"{path}.effects.{name}", "level", LOST_LEVEL)
            for level, of_level in of_factor.items():
                check_keys(of_level, dimensions, f"{path}.effects.{name}.{level}", "dimension")

    def attitude(self, dimension: str, factors: Factors, draws: Draws) -> float:
        """Return the attitude of a participant to a dimension of a cell."""
        levels = {name: cell_text(level) for name, level in factors.items()}
        of_everybody = sum(
            self.effects.get(name, {}).get(text, {}).get(dimension, 0.0) for name, text in levels.items()
        )
        cell = ", ".join(f"{name}={levels[name]}" for name in sorted(levels))
        spreads = (
            (self.attitude_sd, ("attitude",)),
            (self.dimension_sd, ("attitude", dimension)),
            (self.stimulus_sd if levels else 0.0, ("attitude", dimension, cell)),
        )
        return of_everybody + sum(sd * float(draws(*words).standard_normal()) for sd, words in spreads if sd)


@dataclass(frozen=True)
class Rater:
    """Simulated rater.

    - `draws`: Random streams of the participant.
    - `dimension_of`: Dimension of each item, by questionnaire.
    - `factors_of`: Cell of the felt stimulus.
    """

    raters: Raters
    draws: Draws
    dimension_of: Mapping[str, Mapping[str, str]]
    factors_of: Callable[[object], Factors]

    @property
    def extremity(self) -> float:
        return exp(self.raters.extremity_cv * float(self.draws("extremity").standard_normal()))

    @property
    def acquiescence(self) -> float:
        return self.raters.acquiescence_sd * float(self.draws("acquiescence").standard_normal())

    def answers(self, request: Fill, met: object, liking: float, rng: np.random.Generator) -> list[float]:
        """Answer each question of a page from -1 (left) to 1 (right)."""
        factors: Factors = {} if met is None else self.factors_of(met)
        of_item = self.dimension_of[request.form]
        names = {of_item[question.item] for question in request.questions}
        attitudes = {name: self.raters.attitude(name, factors, self.draws) for name in sorted(names)}
        liked = self.raters.liking * liking if factors else 0.0
        extremity, acquiescence = self.extremity, self.acquiescence
        answers = []
        for question, z in zip(request.questions, rng.standard_normal(len(request.questions)).tolist(), strict=True):
            loading = self.raters.loadings.get(question.item, self.raters.loading)
            felt = loading * (attitudes[of_item[question.item]] + liked) + self.raters.noise * z
            answers.append(extremity * (-felt if question.reversed else felt) + acquiescence)
        return [min(max(answer, -1.0), 1.0) for answer in answers]
