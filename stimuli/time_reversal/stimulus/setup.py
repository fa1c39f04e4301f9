"""Screen and focus of a study's stimulus."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from tactometry.arguments.checked import Positive, checked

from ..plate.glass import GLASSES
from ..plate.plate import Plate
from ..responses.responses import Point, Responses, impulse_responses, samples_in
from ..screen.attenuation import TAU_S, Attenuation
from ..screen.glass_panel import LEARNT_S, GlassPanel
from ..screen.screen import Screen
from ..screen.transducer import MOMENT_N_PER_V, SIDE_M, border


@checked
@dataclass(frozen=True)
class Setup(GlassPanel):
    """A screen with its losses, sampling and focus.

    The defaults are the thesis's prototype as far as known (`setup` in `stimuli/sources.toml`).

    Parameters
    ----------
    glass : str
        A name of `tactometry.stimuli.time_reversal.plate.glass.GLASSES`.
    length_m : float
        Length of the plate (x), above 0.
    width_m : float
        Width of the plate (y), above 0.
    thickness_m : float
        Thickness of the plate, above 0.
    boundary : str
        Four letters, as in `Plate`.
    n_transducers : int
        Number of square patches, with centres `inset_m` from the edges.
    tau_s : float
        Time constant of the amplitude of every mode, above 0.
    focus_x_m : float
        Place of the focus along the length of the plate.
    focus_y_m : float
        Place of the focus along the width of the plate.
    rate_hz : float
        Samples per second of drives and responses.
    modes_to_hz : float
        Highest frequency of a mode, at most half of `rate_hz`.
    learnt_s : float
        Length of the learnt responses: the longest reversal time.
    shear_factor : float, optional
        Mindlin's shear factor (5/6). Default: None, a thin plate.
    inset_m : float
        Distance of the patches' centres from the edges.
    side_m : float
        Side of a square patch.
    moment_n_per_v : float
        Bending moment of a patch per length of its outline and volt.

    >>> Setup(boundary="FFFF").plate.boundary
    'FFFF'
    """

    boundary: str = "SSSS"
    side_m: Positive = SIDE_M
    moment_n_per_v: Positive = MOMENT_N_PER_V
    tau_s: Positive = TAU_S
    modes_to_hz: float = 66e3
    learnt_s: Positive = LEARNT_S
    shear_factor: Positive | None = None

    def __post_init__(self) -> None:
        self._check_panel(highest_hz="modes_to_hz")
        self.plate.check_holds("Setup.focus", self.focus_m)
        _ = self.screen

    @property
    def plate(self) -> Plate:
        return GLASSES[self.glass].plate(self.length_m, self.width_m, self.thickness_m, self.boundary)

    @property
    def screen(self) -> Screen:
        patches = border(self.plate, self.n_transducers, self.side_m, self.inset_m, self.moment_n_per_v)
        return Screen(self.plate, patches, Attenuation(self.tau_s), self.shear_factor)

    @property
    def heard_s(self) -> float:
        """Duration of a response: at least `learnt_s`, until it has decayed by 60 dB."""
        return max(self.learnt_s, self.screen.attenuation.t60_s)

    def responses_at(self, x_m: float, y_m: float) -> Responses:
        """Return every channel's displacement response at a point."""
        return self.responses_at_each(((x_m, y_m),))

    def responses_at_each(self, places: Sequence[Point]) -> Responses:
        """Return the responses at points, at least one."""
        return _responses(self, tuple((x_m, y_m) for x_m, y_m in places))

    def learnt(self) -> Responses:
        """Return the first `learnt_s` of the responses at the focus."""
        responses = self.responses_at(*self.focus_m)
        return replace(responses, samples=responses.samples[..., : samples_in("learnt_s", self.learnt_s, self.rate_hz)])


@lru_cache(maxsize=16)
def _responses(setup: Setup, places: tuple[Point, ...]) -> Responses:
    return impulse_responses(
        setup.screen, places, rate_hz=setup.rate_hz, duration_s=setup.heard_s, f_max_hz=setup.modes_to_hz
    )
