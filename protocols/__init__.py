"""Procedures, tasks, blocks and their order.

Classes raise `InvalidParameter` for invalid arguments.
"""

from tactometry.loading import named

from .bayesian.quest import Quest as Quest
from .bayesian.quest_plus import QuestPlus as QuestPlus
from .bayesian.settings import QuestPlusSettings as QuestPlusSettings, psi as psi
from .block import Block as Block
from .block_state import Condition as Condition, Track as Track
from .procedures.constant_stimuli import ConstantStimuli as ConstantStimuli
from .procedures.method_of_limits import MethodOfLimits as MethodOfLimits
from .procedures.staircase import Staircase as Staircase, WeightedStaircase as WeightedStaircase
from .session import session as session
from .tasks.adjustment import AdjustmentTask as AdjustmentTask
from .tasks.comparison import Comparison as Comparison
from .tasks.forced_choice import ForcedChoice as ForcedChoice
from .tasks.localisation import Localisation as Localisation
from .tasks.magnitude import Magnitude as Magnitude
from .tasks.preference import Preference as Preference
from .tasks.rating import Rating as Rating
from .tasks.same_different import SameDifferent as SameDifferent
from .tasks.touch import Pressing as Pressing, Sliding as Sliding
from .tasks.yes_no import YesNo as YesNo

__dir__ = named(__name__)
