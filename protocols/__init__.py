"""What is asked, and when: procedures, tasks, blocks and their order."""

from tactometry.protocols.bayesian.outcome_model import FunctionModel, OutcomeModel, TableModel
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest import Quest
from tactometry.protocols.bayesian.quest_plus import QuestPlus
from tactometry.protocols.bayesian.settings import PsiSettings, QuestPlusSettings, psi
from tactometry.protocols.bayesian.shared_quest_plus import SharedQuestPlus, SharedTrack
from tactometry.protocols.block import Block, Condition, Track
from tactometry.protocols.order import counterbalanced, williams_square
from tactometry.protocols.procedures.constant_stimuli import ConstantStimuli
from tactometry.protocols.procedures.method_of_limits import MethodOfLimits
from tactometry.protocols.procedures.procedure import Ending, Procedure
from tactometry.protocols.procedures.shared_learning import Sharing, answered
from tactometry.protocols.procedures.staircase import Staircase
from tactometry.protocols.procedures.weighted_staircase import WeightedStaircase
from tactometry.protocols.session import Inquiry, session
from tactometry.protocols.tasks.adjustment import AdjustmentTask
from tactometry.protocols.tasks.comparison import Comparison
from tactometry.protocols.tasks.forced_choice import ForcedChoice
from tactometry.protocols.tasks.localisation import Localisation
from tactometry.protocols.tasks.magnitude import Magnitude
from tactometry.protocols.tasks.measurement import Measurement
from tactometry.protocols.tasks.preference import Preference
from tactometry.protocols.tasks.rating import Rating
from tactometry.protocols.tasks.same_different import SameDifferent
from tactometry.protocols.tasks.touch import Pressing, Sliding
from tactometry.protocols.tasks.yes_no import YesNo

__all__ = [
    "AdjustmentTask",
    "Block",
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
