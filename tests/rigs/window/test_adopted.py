"""Adopted windows of PsychoPy scripts, restored after use."""

import threading
import time

import numpy as np
import pytest
from hands import SCREEN_PX
from patience import LONGEST_WAIT_S

from tactometry.errors import InvalidParameter
from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.pages.page import PAPER, Page
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Choose, Wait

KEPT = ("units", "colorSpace", "viewPos", "viewScale", "viewOri", "mouseVisible", "blendMode", "waitBlanking")
LOOKS = {
    "plain": {},
    "of their own": {"units": "norm", "viewScale": (0.5, 0.8), "viewPos": (0.2, 0.1), "viewOri": 20.0},
}


@pytest.fixture(scope="module")
def theirs(display):
    from tactometry.rigs.window import load_psychopy

    psychopy = load_psychopy()
    look = {"color": (0.5, -0.5, 0.0), "units": "pix", "monitor": psychopy.monitors.Monitor("theirs", width=50)}
    window = psychopy.visual.Window(SCREEN_PX, **look, checkTiming=False, gammaErrorPolicy="ignore", autoLog=False)
    yield window
    window.close()


@pytest.fixture(params=LOOKS)
def scene(theirs, request):
    from psychopy import visual

    for name, value in ({"viewScale": None, "viewPos": None, "viewOri": 0.0} | LOOKS[request.param]).items():
        setattr(theirs, name, value)
    patch = visual.Rect(theirs, width=0.5, height=0.5, pos=(0.2, 0), fillColor="yellow", units="norm", autoLog=False)
    patch.autoDraw = True
    theirs.flip()
    yield theirs
    patch.autoDraw = False
    theirs.flip()


@pytest.fixture
def window(scene):
    from tactometry.rigs.window import Window

    adopted = Window.adopt(scene)
    yield adopted
    adopted.close()


def seen(window):
    """Return the picture that a flip of the script shows."""
    for stimulus in window._toDraw:
        stimulus.draw()
    picture = np.asarray(window.getMovieFrame(buffer="back"))
    window.movieFrames = []
    window.flip()
    return picture


def state(window):
    named = {name: getattr(window, name) for name in KEPT}
    return named | {
        "color": tuple(window.color),
        "viewport": tuple(window.viewport),
        "scissor": tuple(window.scissor),
        "drawn": list(window._toDraw),
        "stack": len(window.winHandle._event_stack),
    }


def test_page_hides_everything_the_script_draws(scene, window, hands):
    window.present(Page())
    window.refresh(Page())
    rgb = [int(PAPER[n : n + 2], 16) for n in (1, 3, 5)]
    assert np.abs(hands.sees()[..., :3].astype(int) - rgb).max() <= 1


def test_page_fills_screen_despite_script_viewport(scene, window, hands):
    part = (0, 0, 300, 200)
    scene.viewport = scene.scissor = part
    window.present(Page())
    assert len(np.unique(hands.sees().reshape(-1, 3), axis=0)) == 1
    window.give_back()
    assert (tuple(scene.viewport), tuple(scene.scissor)) == (part, part)
    scene.resetViewport()


def test_closing_does_not_close_the_script_window(scene, window):
    window.present(Page())
    window.close()
    window.close()
    assert not scene._closed
    assert scene._toDraw
    scene.flip()


def test_script_flip_callbacks_wait_for_script_flip(scene, window):
    called, scene.recordFrameIntervals = [], True
    scene.flip()
    scene.flip()
    n_intervals = len(scene.frameIntervals)
    scene.callOnFlip(called.append, 1)
    for _ in range(3):
        window.refresh(Page())
    window.give_back()
    assert called == []
    scene.flip()
    assert called == [1]
    assert len(scene.frameIntervals) == n_intervals  # the interval that spans our page is not counted
    scene.recordFrameIntervals = False


def wait_for(found):
    deadline_s = time.perf_counter() + LONGEST_WAIT_S
    while time.perf_counter() < deadline_s:
        if heard := found():
            return heard
    raise AssertionError("nothing was heard")


def test_keys_go_to_owner_of_current_page(scene, window, hands):
    from psychopy import event
    from psychopy.hardware.keyboard import Keyboard

    keyboard = Keyboard(backend="ptb")
    clock = keyboard.clock

    def taps(key):
        hands.tap(key)
        time.sleep(0.4)  # until PsychoPy's thread has read it

    taps("a")
    window.present(Page())
    taps("b")
    assert [event.name for event in wait_for(window.events)] == ["b"]
    taps("c")
    window.give_back()
    taps("d")
    heard = []
    wait_for(lambda: heard.extend(key.name for key in keyboard.getKeys()) or "d" in heard)
    assert heard == ["a", "d"]
    assert keyboard.clock is clock
    assert {"b", "c"} & set(event.getKeys()) == set()


def test_press_time_is_correct_with_another_clock(scene, window, hands):
    """Builder scripts set another clock after creating their components."""
    from psychopy import clock, logging

    window.present(Page())
    usual = logging.defaultClock
    logging.setDefaultClock(clock.Clock())
    try:
        down_s, _ = hands.tap("y")
        [press] = wait_for(window.events)
    finally:
        logging.setDefaultClock(usual)
    assert press.at_s == pytest.approx(down_s, abs=1.0)  # the clocks differ by more than this


def test_key_held_past_last_page_is_ignored(scene, window, hands, in_background):
    from psychopy.hardware.keyboard import Keyboard

    keyboard = Keyboard(backend="ptb")
    window.present(Page())
    in_background(hands.tap, "y", 0.5)
    assert [event.name for event in wait_for(window.events)] == ["y"]
    window.give_back()
    time.sleep(0.6)
    assert keyboard.getKeys(waitRelease=False) + keyboard.getKeys(waitRelease=True) == []


def test_rig_restores_window_after_each_answer(scene, output, hands, in_background):
    from tactometry.rigs.window import Window

    before, looked = state(scene), seen(scene)
    rig = Bench(Window.adopt(scene), Equipment(output, {}), texts_in("en", {}))
    assert rig.facts()["window_adopted"] is True
    assert state(scene) == before
    rig.answer(Wait(0.05))
    assert state(scene) == before
    assert np.array_equal(seen(scene), looked)
    answered = threading.Event()

    def tap_until_answered():
        while not answered.wait(0.3):
            hands.tap("y")

    in_background(tap_until_answered)
    try:
        assert rig.answer(Choose("felt", (0, 1), ("no", "yes"))).option == 1
    finally:
        answered.set()
    assert state(scene) == before
    rig.close()
    assert state(scene) == before
    assert np.array_equal(seen(scene), looked)


def test_adopt_rejects_other_types(display):
    from tactometry.rigs.window import Window

    with pytest.raises(InvalidParameter, match=r"Window\.adopt: found str, expected an open psychopy\.visual\.Window"):
        Window.adopt("win")
