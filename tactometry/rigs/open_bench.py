"""A bench with a PsychoPy window."""

from collections.abc import Callable, Mapping

from ..devices.outputs.guarded import Guarded
from ..devices.outputs.output import RAMP_S, NullOutput
from ..devices.sensors.force_sensor import ForceSensor
from ..devices.sensors.position_sensor import PositionSensor
from ..safety.limits import Limits
from ..session.event import EventLog
from ..signal import Stimulus
from .bench import Bench, Facts
from .experimenter.terminal import ExperimenterTerminal
from .texts import texts_in


def open_bench(
    bank: Mapping[str, Stimulus],
    limits: Limits | None,
    texts: Mapping[str, str],
    *,
    language: str = "en",
    fullscreen: bool,
    size: tuple[int, int] | None = None,
    output: Guarded | None = None,
    sensor: ForceSensor | None = None,
    position: PositionSensor | None = None,
    display_height_m: float | None = None,
    ramp_s: float = RAMP_S,
    release: bool = True,
    device_facts: Callable[[], Facts] = dict,
    log: EventLog | None = None,
    terminal: ExperimenterTerminal | None = None,
) -> Bench:
    """A bench with a PsychoPy window.

    Parameters
    ----------
    bank : mapping of str to Stimulus
        The stimuli by the names that requests use.
    limits : Limits or None
        What the study allows, checked beside the limits of the output.
    texts : mapping of str to str
        The study's own messages and labels, above those of the language.
    language : str
        One of `tactometry.rigs.texts.languages()`.
    fullscreen, size
        The window; `size` in pixels where it is not full screen.
    output : Guarded, optional
        Without one, a guarded `NullOutput` with the study's limits: nothing reaches a finger.
    sensor : ForceSensor, optional
        Without one, the force is not measured: its fields are None and every touch is valid.
    position : PositionSensor, optional
        Without one, the finger's speed is not measured.
    ramp_s : float
        Ramps of signals that do not begin and end at rest; 0 for one-bit outputs.
    release : bool
        Whether the force must leave its band between touches.
    device_facts : callable
        What the head of the journal says of the devices, once they are open, and their clocks at any time.
    display_height_m : float, optional
        Measured height of the visible picture, m, for the moving cue of a `Slide`; without it
        `ASSUMED_DISPLAY_HEIGHT_M`, and the journal says that the height was not measured.
    log : EventLog, optional
        Where pauses, remarks, clocks and the timing of each trial are kept.
    terminal : ExperimenterTerminal, optional
        The experimenter's terminal.

    Raises
    ------
    InvalidParameter
        If the language is not shipped.
    DeviceFailed
        If there is no PsychoPy, display or keyboard, or a device does not open.
    """
    from .window import Window

    words = texts_in(language, texts)
    window = Window(fullscreen=fullscreen, size=size)
    if window.caution is not None and terminal is not None:
        terminal.tell(window.caution)
    return Bench(
        window,
        Guarded(NullOutput(), limits) if output is None else output,
        bank,
        limits=limits,
        texts=words,
        sensor=sensor,
        position=position,
        display_height_m=display_height_m,
        ramp_s=ramp_s,
        release=release,
        device_facts=device_facts,
        log=log,
        terminal=terminal,
    )
