"""What is published of the moving skin of a finger pad, per sliding speed from 20 to 100 mm/s."""

from typing import Final

MASS_KG_PER_M_PER_S: Final = 3.23e-2
STIFFNESS_N_S_PER_M2: Final = 4_040.0
CUTOFF_HZ_S_PER_M: Final = 13_800.0
