"""What is asked, and when: procedures, tasks, blocks and their order."""

from .bayesian.outcome_model import FunctionModel, OutcomeModel, TableModel
from .bayesian.parameter_grid import ParameterGrid
from .bayesian.quest import Quest
from .bayesian.quest_plus import QuestPlus
from .bayesian.settings import PsiSettings, QuestPlusSettings, psi
from .bayesian.shared_quest_plus import SharedQuestPlus, SharedTrack
from .block import Block
from .block_state import BlockOptions
from .order import counterbalanced, williams_square
from .procedures.constant_stimuli import ConstantStimuli
from .procedures.method_of_limits import MethodOfLimits
from .procedures.procedure import Ending, Procedure
from .procedures.shared_learning import Sharing, answered
from .procedures.staircase import Staircase
from .procedures.weighted_staircase import WeightedStaircase
from .session import Inquiry, session
from .tasks.adjustment import AdjustmentTask
from .tasks.comparison import Comparison
from .tasks.forced_choice import ForcedChoice
from .tasks.localisation import Localisation
from .tasks.magnitude import Magnitude
from .tasks.measurement import Measurement
from .tasks.preference import Preference
from .tasks.rating import Rating
from .tasks.same_different import SameDifferent
from .tasks.touch import Pressing, Sliding
from .tasks.yes_no import YesNo
from .track import Condition, Track

__all__ = [
    "AdjustmentTask",
    "Block",
    "BlockOptions",
    "Comparison",
    "Condition",
    "ConstantStimuli",
    "Ending",
    "ForcedChoice",
    "FunctionModel",
    "Inquiry",
    "Localisation",
    "Magnitude",
    "Measurement",
    "MethodOfLimits",
    "OutcomeModel",
    "ParameterGrid",
    "Preference",
    "Pressing",
    "Procedure",
    "PsiSettings",
    "Quest",
    "QuestPlus",
    "QuestPlusSettings",
    "Rating",
    "SameDifferent",
    "SharedQuestPlus",
    "SharedTrack",
    "Sharing",
    "Sliding",
    "Staircase",
    "TableModel",
    "Track",
    "WeightedStaircase",
    "YesNo",
    "answered",
    "counterbalanced",
    "psi",
    "session",
    "williams_square",
]
