"""What is asked, and when: procedures, tasks, blocks and their order."""

from tactometry.protocols.adjustment import AdjustmentTask
from tactometry.protocols.block import Block, Condition, Track
from tactometry.protocols.comparison import Comparison
from tactometry.protocols.constant_stimuli import ConstantStimuli
from tactometry.protocols.forced_choice import ForcedChoice
from tactometry.protocols.localisation import Localisation
from tactometry.protocols.magnitude import Magnitude
from tactometry.protocols.order import counterbalanced, williams_square
from tactometry.protocols.parameter_grid import ParameterGrid
from tactometry.protocols.preference import Preference
from tactometry.protocols.procedure import Ending, Procedure
from tactometry.protocols.quest_plus import QuestPlus
from tactometry.protocols.rating import Rating
from tactometry.protocols.same_different import SameDifferent
from tactometry.protocols.session import Inquiry, session
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
    "Inquiry",
    "Localisation",
    "Magnitude",
    "ParameterGrid",
    "Preference",
    "Pressing",
    "Procedure",
    "QuestPlus",
    "Rating",
    "SameDifferent",
    "Sliding",
    "Staircase",
    "Track",
    "WeightedStaircase",
    "YesNo",
    "counterbalanced",
    "session",
    "williams_square",
]
