"""What is asked, and when: procedures, tasks, blocks and their order."""

from tactometry.protocols.block import Block, Condition, Track, session
from tactometry.protocols.constant_stimuli import ConstantStimuli
from tactometry.protocols.forced_choice import ForcedChoice
from tactometry.protocols.order import counterbalanced, williams_square
from tactometry.protocols.parameter_grid import ParameterGrid
from tactometry.protocols.procedure import Ending, Procedure
from tactometry.protocols.quest_plus import QuestPlus
from tactometry.protocols.staircase import Staircase
from tactometry.protocols.touch import Pressing, Sliding
from tactometry.protocols.weighted_staircase import WeightedStaircase
from tactometry.protocols.yes_no import YesNo

__all__ = [
    "Block",
    "Condition",
    "ConstantStimuli",
    "Ending",
    "ForcedChoice",
    "ParameterGrid",
    "Pressing",
    "Procedure",
    "QuestPlus",
    "Sliding",
    "Staircase",
    "Track",
    "WeightedStaircase",
    "YesNo",
    "counterbalanced",
    "session",
    "williams_square",
]
