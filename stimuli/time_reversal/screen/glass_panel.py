"""Fields of a glass panel with transducers, a focus and a clock."""

from dataclasses import dataclass
from typing import Final

from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect, one_of, positive, whole

from ..plate.glass import BOROFLOAT_33, GLASSES
from .transducer import INSET_M, MAX_TRANSDUCERS

LEARNT_S: Final = 7e-3
"""Length of the responses, twice the default tau; range: `setup` in `stimuli/sources.toml`."""


@checked
@dataclass(frozen=True)
class GlassPanel:
    """Screen fields shared by a study's setup and a scene's surface.

    The subclasses describe the fields. The defaults are the thesis's prototype as far as known.
    """

    glass: str = BOROFLOAT_33.name
    length_m: float = 0.297
    width_m: float = 0.210
    thickness_m: float = 1.1e-3
    n_transducers: int = 32
    inset_m: float = INSET_M
    focus_x_m: float = 0.121
    focus_y_m: float = 0.093
    rate_hz: float = 250e3

    @property
    def focus_m(self) -> tuple[float, float]:
        return self.focus_x_m, self.focus_y_m

    def _check_panel(self, *, highest_hz: str) -> None:
        """Raise an error for an invalid panel, with the field `highest_hz`."""
        owner = type(self).__name__
        one_of(f"{owner}.glass", self.glass, tuple(GLASSES))
        whole(owner, lowest=1, highest=MAX_TRANSDUCERS, n_transducers=self.n_transducers)
        found_hz: float = getattr(self, highest_hz)
        positive(owner, rate_hz=self.rate_hz, **{highest_hz: found_hz})
        expected = f"at most half of rate_hz, {self.rate_hz / 2}; lower it or raise rate_hz"
        expect(2 * found_hz <= self.rate_hz, f"{owner}.{highest_hz}", found_hz, expected)
