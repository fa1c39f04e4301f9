"""Predict sensation levels, JNDs and too weak conditions of a study."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf, sqrt
from statistics import NormalDist

import numpy as np

from tactometry.contact import Contact
from tactometry.observers.people import Feeling, Stated
from tactometry.observers.psychometric import OF_WIDTH, PsychometricObserver
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.position_dependent import felt_under, straight_way
from tactometry.protocols.batch.answers import LevelTable
from tactometry.protocols.procedures.procedure import OfLevels
from tactometry.protocols.tasks.comparison import Comparison
from tactometry.protocols.tasks.task import AgainstStandard
from tactometry.session.request import TRAJECTORY_M
from tactometry.signal import Signal
from tactometry.trials.cells import cell as cell_text

from .cells import WiredCell
from .experiment import Experiment
from .own_parts import Unseen

N_LEVELS = 81
SILENT_DB = -200.0
"""Sensation level of an imperceptible stimulus, in tables that require a finite number."""
BELOW_DB = 40.0
"""How far below the levels of a study a threshold is searched."""
UNFELT_DB, TOLERANCE_DB = -300.0, 1e-3
TOLERATED_DB = 0.05
"""Distance below the threshold that is tolerated, as it would be printed as 0 dB."""
NEAR_DB = 10.0
"""Distance below which a standard is near the threshold: two standard deviations between participants (unverified
default)."""
JND_PER_SD = NormalDist().inv_cdf(0.75)


def contact_of(cell: WiredCell) -> Contact:
    """Return a cell's requested contact. Defaults are no force and no speed."""
    request = cell.condition.touch.request(cell.condition.stimulus, None, None)
    return Contact(getattr(request, "target_n", None) or 0.0, getattr(request, "speed_m_per_s", None) or 0.0)


def played(cell: WiredCell, level: float, speed_m_per_s: float) -> Signal:
    """Return the signal at a level, felt by a finger on a straight path."""
    signal = cell.stimulus.at(level)
    return felt_under(cell.stimulus, signal, *straight_way(signal.duration_s, speed_m_per_s, TRAJECTORY_M))


def felt_db(cell: WiredCell, level: float, contact: Contact) -> float:
    """Return the sensation level (dB), or -inf if nothing is felt."""
    return cell.sensation.sensation_db(played(cell, level, contact.speed_m_per_s), contact)


def threshold_db(sensation_db: Callable[[float], float], bounds: tuple[float, float]) -> float | None:
    """Return the level (dB) at a sensation level of 0 dB.

    The result is None if no level within the bounds is felt, or if all are, even `BELOW_DB` below the bounds.
    """
    from scipy.optimize import brentq  # slow to load

    def above_db(level_db: float) -> float:
        return max(sensation_db(level_db), UNFELT_DB)

    low_db, high_db = bounds
    if not above_db(low_db - BELOW_DB) < 0 <= above_db(high_db):
        return None
    return float(brentq(above_db, low_db - BELOW_DB, high_db, xtol=TOLERANCE_DB))


def level_table(cell: WiredCell, levels: Sequence[float] | None = None, contact: Contact | None = None) -> LevelTable:
    """Return sensation levels (dB) by level, from a cell's sensation model.

    - `levels`: Increasing levels. Levels between them are interpolated. By default the levels of the procedure, or
      `N_LEVELS` levels over its range.
    - `contact`: Contact of the finger, by default the one that the cell requests.
    """
    contact = contact_of(cell) if contact is None else contact
    rule = cell.procedure.rule
    if not levels:
        over_range = np.linspace(*rule.bounds, N_LEVELS).tolist()
        levels = sorted(set(rule.levels)) if isinstance(rule, OfLevels) else over_range
    sensations_db = [max(felt_db(cell, level, contact), SILENT_DB) for level in levels]
    return LevelTable(np.asarray(levels, dtype=np.float64), np.asarray(sensations_db))


@dataclass(frozen=True)
class Unfelt:
    """Condition with an imperceptible strongest level or a weak standard.

    `sensation_db` is the sensation level of this level or standard. It is None if nothing is felt.
    """

    condition: str
    level: str
    sensation_db: float | None
    is_standard: bool = False

    @property
    def line(self) -> str:
        """Warning about the condition.

        >>> Unfelt("frequency_hz 60", "36 dB re 1 V", -28.74).line
        'WARNING: even the strongest level (36 dB re 1 V) is 28.7 dB below the predicted threshold at frequency_hz 60'
        >>> Unfelt("", "36 dB re 1 V", None).line
        'WARNING: even the strongest level (36 dB re 1 V) is not felt at all'
        >>> Unfelt("", "40 dB re 1 V", 2.5, is_standard=True).line.partition(":")[2][:67]
        ' the standard (40 dB re 1 V) is 2.5 dB above the predicted threshol'
        """
        level = f"the standard ({self.level})" if self.is_standard else f"even the strongest level ({self.level})"
        distance = "not felt at all"
        if self.sensation_db is not None:
            side = "below" if self.sensation_db < 0 else "above"
            distance = f"{abs(self.sensation_db):.1f} dB {side} the predicted threshold"
        effect = ": some participants may not feel it" if self.is_standard else ""
        return f"WARNING: {level} is {distance}{_at(self.condition)}{effect}"


def unfelt(experiment: Experiment, *, simulated: bool = False) -> Iterator[Unfelt]:
    """Yield conditions whose strongest level or standard is too weak.

    Sensation is predicted by the physics. With `simulated`, thresholds stated by the observer take precedence.
    """
    middle, task = experiment.people.middle, experiment.task
    for cell in experiment.cells.values():
        if isinstance(cell.sensation, Unseen):  # custom code is not allowed to run
            continue
        checked = [(cell.procedure.rule.bounds[1], -TOLERATED_DB, False)]
        if isinstance(task, AgainstStandard):
            checked.append((task.standard_level, NEAR_DB, True))
        feeling = middle.stated(cell.condition.factors) if simulated and isinstance(middle, Stated) else Feeling()
        for level, lowest_db, is_standard in checked:
            felt = feeling.felt_db(level, partial(felt_db, cell, level, contact_of(cell)))
            if felt < lowest_db:
                text = f"{level:g} {cell.stimulus.level_unit}"
                yield Unfelt(_name(cell), text, None if felt == -inf else felt, is_standard)
                break


@dataclass(frozen=True)
class PredictedJnd:
    """Predicted JND of a condition, in the unit of the level.

    The JND is None if it lies above the highest level. Lapses are ignored. With `feels_touch`, variations of force and
    speed between touches are ignored too.
    """

    condition: str
    standard: str
    jnd: float | None
    feels_touch: bool = True

    @property
    def line(self) -> str:
        """Prediction in words.

        >>> PredictedJnd("force_n 1", "40 dB re 1 V", 1.234).line
        'predicted JND at the standard of 40 dB re 1 V: 1.23 dB at force_n 1 (constant touch; variation increases it)'
        """
        unit = self.standard.partition(" ")[2].partition(" re ")[0]
        size = "above the highest level" if self.jnd is None else f"{self.jnd:.2f} {unit}".rstrip()
        steady = " (constant touch; variation increases it)" if self.feels_touch else ""
        return f"predicted JND at the standard of {self.standard}: {size}{_at(self.condition)}{steady}"


def predicted_jnds(experiment: Experiment) -> Iterator[PredictedJnd]:
    """Yield the JND of each condition of a comparison, for built-in observers."""
    if not isinstance(experiment.task, Comparison):
        return
    standard, people = experiment.task.standard_level, experiment.people.middle
    for cell in experiment.cells.values():
        if isinstance(people, PsychometricObserver):
            stretch = people.stated(cell.condition.factors).stretch
            jnd: float | None = JND_PER_SD * people.width / OF_WIDTH / stretch
        elif isinstance(people, SignalDetectionObserver) and not isinstance(cell.sensation, Unseen):
            jnd = _of_signal(cell, people, standard)
        else:
            continue
        feels_touch = isinstance(people, SignalDetectionObserver)
        yield PredictedJnd(_name(cell), f"{standard:g} {cell.stimulus.level_unit}", jnd, feels_touch)


def _of_signal(cell: WiredCell, people: SignalDetectionObserver, standard: float) -> float | None:
    """Return the JND: the level increment judged stronger in 75 % of trials.

    The noise of the two intervals is independent.
    """
    from scipy.optimize import brentq  # slow to load

    def excess(level: float) -> float:
        felt, of_standard = (people.d_prime(felt_db(cell, each, contact_of(cell))) for each in (level, standard))
        return felt - of_standard - sqrt(2) * JND_PER_SD

    highest = cell.procedure.rule.bounds[1]
    if highest <= standard or excess(highest) < 0:
        return None
    return float(brentq(excess, standard, highest, xtol=1e-6)) - standard


def _name(cell: WiredCell) -> str:
    return ", ".join(f"{factor} {cell_text(value)}" for factor, value in cell.condition.factors.items())


def _at(condition: str) -> str:
    return f" at {condition}" if condition else ""
