"""Colours of all figures (Okabe and Ito 2008)."""

from typing import Final

BLUE: Final = "#0072B2"
ORANGE: Final = "#D55E00"
GREEN: Final = "#009E73"
PINK: Final = "#CC79A7"
GOLD: Final = "#E69F00"
SKY: Final = "#56B4E9"
BLACK: Final = "#000000"
COLOURS: Final = (BLUE, ORANGE, GREEN, PINK, GOLD, SKY, BLACK)
