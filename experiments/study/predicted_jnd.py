"""Just noticeable differences of comparisons, as the simulated observer of a study predicts them."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from statistics import NormalDist

from tactometry.observers.psychometric import OF_WIDTH, PsychometricObserver
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols.tasks.comparison import Comparison
from tactometry.trials.cells import cell as cell_text

from .cells import WiredCell
from .experiment import Experiment
from .felt_levels import contact_of, felt_db
from .own_parts import Unseen

JND_PER_SD = NormalDist().inv_cdf(0.75)


@dataclass(frozen=True)
class PredictedJnd:
    """The JND of one condition, in the unit of the level; None if it is larger than the levels allow.

    Lapses are left out, and where the skin `feels_touch` the force and speed that vary from touch to touch.
    """

    condition: str
    standard: str
    jnd: float | None
    feels_touch: bool = True

    @property
    def line(self) -> str:
        """State it in words.

        >>> PredictedJnd("force_n 1", "40 dB re 1 V", 1.234).line
        'predicted JND at the standard of 40 dB re 1 V: 1.23 dB at force_n 1 (steady touch; varying ones add to it)'
        """
        where = f" at {self.condition}" if self.condition else ""
        unit = self.standard.partition(" ")[2].partition(" re ")[0]
        size = "above the highest level" if self.jnd is None else f"{self.jnd:.2f} {unit}".rstrip()
        steady = " (steady touch; varying ones add to it)" if self.feels_touch else ""
        return f"predicted JND at the standard of {self.standard}: {size}{where}{steady}"


def predicted_jnds(experiment: Experiment) -> Iterator[PredictedJnd]:
    """Yield the JND of each condition of a comparison, where the observer is one of ours."""
    if not isinstance(experiment.task, Comparison):
        return
    standard, people = experiment.task.standard_level, experiment.people.middle
    for cell in experiment.cells.values():
        factors = cell.condition.factors
        if isinstance(people, PsychometricObserver):
            jnd: float | None = JND_PER_SD * people.width / OF_WIDTH / people.stated(factors).stretch
        elif isinstance(people, SignalDetectionObserver) and not isinstance(cell.sensation, Unseen):
            jnd = _of_signal(cell, people, standard)
        else:
            continue
        name = ", ".join(f"{factor} {cell_text(value)}" for factor, value in factors.items())
        feels_touch = isinstance(people, SignalDetectionObserver)
        yield PredictedJnd(name, f"{standard:g} {cell.stimulus.level_unit}", jnd, feels_touch)


def _of_signal(cell: WiredCell, people: SignalDetectionObserver, standard: float) -> float | None:
    """How far above the standard a level is stronger in 75 % of comparisons, each with two noises."""
    from scipy.optimize import brentq  # slow to load

    def excess(level: float) -> float:
        felt, of_standard = (people.d_prime(felt_db(cell, each, contact_of(cell))) for each in (level, standard))
        return felt - of_standard - sqrt(2) * JND_PER_SD

    highest = cell.procedure.rule.bounds[1]
    if highest <= standard or excess(highest) < 0:
        return None
    return float(brentq(excess, standard, highest, xtol=1e-6)) - standard
