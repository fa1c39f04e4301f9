"""Every kind of result, in the order of the page: a new one is a file in `sections` and a line here."""

from .section import ResultKind
from .sections.force import FORCE
from .sections.hierarchical import HIERARCHICAL
from .sections.loss import LOSS
from .sections.outcomes import OUTCOMES
from .sections.participants import PARTICIPANTS
from .sections.quality import QUALITY
from .sections.questionnaires import QUESTIONNAIRES
from .sections.rates import RATES
from .sections.task_tables import TASK_TABLES

KINDS: tuple[ResultKind, ...] = (
    OUTCOMES,
    HIERARCHICAL,
    QUESTIONNAIRES,
    TASK_TABLES,
    LOSS,
    FORCE,
    QUALITY,
    RATES,
    PARTICIPANTS,
)
