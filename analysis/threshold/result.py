"""What a fit of one data set says."""

from dataclasses import dataclass

from tactometry.psychometric import PsychometricFunction

from .status import Status


@dataclass(frozen=True)
class ThresholdFit:
    """What the answers say about one threshold.

    `threshold` and the interval are in the unit of the levels (`width` too; for the shape ``weibull`` it is
    in natural logarithms of the level). None: the data do not tell. Where only a bound is known
    (`threshold_below_range`, `threshold_above_range`) the threshold is None and one end of the interval is
    the bound. Without a threshold for another reason, as for `flat`, the interval is that of the posterior, and an end
    is None if the threshold may lie beyond the levels on its side with a probability above 0.2. `deviance` is that of
    the mode of posterior or likelihood. `note` explains a status and is empty for ``ok``.

    `method` is ``posterior`` also where the likelihood was asked for but has no maximum, as without a threshold or
    where the answers change in one step; a maximum of the likelihood has no interval.

    `threshold_mode`, `threshold_median` and `threshold_mean` are those of the posterior, whatever the method;
    with overdispersion they are those of the beta-binomial posterior, as the interval is.
    `probability_below`, `probability_within` and `probability_above` are the posterior probabilities on which the
    status rests: the threshold lies so far below the levels that all are on the upper asymptote; the levels meet the
    rise of the function; it lies so far above them that all are on the lower asymptote (None for fewer than two
    levels).

    Of a comparison (`equality.fit_comparisons`) `threshold` is the point of subjective equality, where half of all
    answers are "more", `middle` the middle of the curve between its asymptotes, and `jnd` the distance to 75 % "more".
    """

    threshold: float | None
    width: float | None
    lapse_rate: float | None
    guess_rate: float | None
    overdispersion: float | None
    interval_low: float | None
    interval_high: float | None
    width_low: float | None
    width_high: float | None
    status: Status
    deviance: float | None
    n_trials: int
    n_levels: int
    shape: str
    method: str
    interval: float
    note: str
    threshold_mode: float | None = None
    threshold_median: float | None = None
    threshold_mean: float | None = None
    probability_below: float | None = None
    probability_within: float | None = None
    probability_above: float | None = None
    middle: float | None = None
    jnd: float | None = None
    jnd_low: float | None = None
    jnd_high: float | None = None

    @property
    def function(self) -> PsychometricFunction | None:
        """The fitted curve, or None where there is none."""
        if None in (self.threshold, self.width, self.lapse_rate, self.guess_rate):
            return None
        return PsychometricFunction(
            self.shape,
            self.threshold if self.middle is None else self.middle,  # type: ignore[arg-type]
            self.width,  # type: ignore[arg-type]
            self.guess_rate,  # type: ignore[arg-type]
            self.lapse_rate,  # type: ignore[arg-type]
        )
