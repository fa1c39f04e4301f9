"""What is asked, and when: procedures, tasks, blocks and their order."""

from tactometry.protocols.adjustment import AdjustmentTask
from tactometry.protocols.block import Block, Condition, Track
from tactometry.protocols.comparison import Comparison
from tactometry.protocols.constant_stimuli import ConstantStimuli
from tactometry.protocols.forced_choice import ForcedChoice
from tactometry.protocols.localisation import Localisation
from tactometry.protocols.magnitude import Magnitude
from tactometry.protocols.measurement import Measurement
from tactometry.protocols.method_of_limits import MethodOfLimits
from tactometry.protocols.order import counterbalanced, williams_square
from tactometry.protocols.outcome_model import FunctionModel, OutcomeModel, TableModel
from tactometry.protocols.parameter_grid import ParameterGrid
from tactometry.protocols.pool import Sharing, answered
from tactometry.protocols.preference import Preference
from tactometry.protocols.procedure import Ending, Procedure
from tactometry.protocols.quest import Quest
from tactometry.protocols.quest_plus import QuestPlus
from tactometry.protocols.quest_plus_settings import PsiSettings, QuestPlusSettings, psi
from tactometry.protocols.rating import Rating
from tactometry.protocols.same_different import SameDifferent
from tactometry.protocols.session import Inquiry, session
from tactometry.protocols.shared_quest_plus import SharedQuestPlus, SharedTrack
from tactometry.protocols.staircase import Staircase
from tactometry.protocols.touch import Pressing, Sliding
from tactometry.protocols.weighted_staircase import WeightedStaircase
from tactometry.protocols.yes_no import YesNo

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
