"""What a frame of the participant's pages costs at 1920 x 1080, drawn in software: processor time of all threads, ms.

Printed for each page, in one run, with its flip:

- ours: the frame that `Canvas` draws, of a page that changes as it does in a session (force and place of the
  finger, or the mark of a form, in every frame);
- plain: each place, size and colour written in every frame, as PsychoPy is used without more;
- ratio: plain over ours.

Limits: 3 ms of a page with force, 16 ms of a questionnaire. Needs Xvfb (`xvfb-run`) and the extra window.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

from measured import tell

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

SIZE = (1920, 1080)
N_FRAMES, N_WARM = 60, 6
FORMS = (("attrakdiff", "en"), ("nasa-tlx", "en"), ("sus", "en"), ("pleasantness-vas", "en"))
LINE = "{:<24}{:>9}{:>9}{:>9}"


def with_display():
    """A virtual display of its own, which ends with this process."""
    read_end, write_end = os.pipe()
    size = "{}x{}x24".format(*SIZE)
    command = ["setpriv", "--pdeathsig", "KILL", "Xvfb", "-displayfd", str(write_end), "-screen", "0", size]
    subprocess.Popen(command, pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        os.environ["DISPLAY"] = f":{answer.readline().strip()}"


def cpu_ms(window, draw, pages):
    """Processor time of a frame, from page to page, all of them known."""
    for page in (*pages[:N_WARM], *pages):
        draw(page)
        window._flip()
    begin_s = time.process_time()
    for k in range(N_FRAMES):
        draw(pages[k % len(pages)])
        window._flip()
    return 1e3 * (time.process_time() - begin_s) / N_FRAMES


def plain(canvas):
    """Draws as one does with PsychoPy without more: a stimulus for each item, placed in every frame."""
    from tactometry.rigs.pages.page import Text

    stimuli = {}

    def text(k, item):
        stimulus = stimuli.get((k, item)) or stimuli.setdefault((k, item), canvas._text(item))
        stimulus.pos = (item.x, item.y)
        return stimulus

    def shape(k, item):
        look, size = canvas._look(item)
        stimulus = stimuli.get((k, look)) or stimuli.setdefault((k, look), canvas._shape(*look))
        stimulus.pos, stimulus.size = (item.x, item.y), size
        stimulus.fillColor, stimulus.lineColor = item.fill, item.line
        return stimulus

    def draw(page):
        for k, item in enumerate(page.items):
            (text if isinstance(item, Text) else shape)(k, item).draw()

    return draw


def touch_pages(words):
    """Pages with a force that rises and a finger that slides; the same without a track."""
    from tactometry.rigs.pages import layout

    marker = layout.marker_page(1, playing=False, words=words)
    pressed = [layout.force_page(marker, 0.5 + 0.01 * k, 1.0, 0.2) for k in range(N_FRAMES)]
    cues = [layout.sweep(k / N_FRAMES) for k in range(N_FRAMES)]
    slid = [layout.track_page(page, cue, 1 / 3, 0.9 * cue) for page, cue in zip(pressed, cues, strict=True)]
    return {"force": pressed, "force and track": slid}


def main():
    with_display()
    import screens

    from tactometry.rigs.texts import texts_in
    from tactometry.rigs.window import Window

    window = Window(fullscreen=False, size=SIZE)
    moving = touch_pages(texts_in("en", {}).message("slide_force"))
    forms = {f"form {name}": screens.form_pages(name, language, window.aspect) for name, language in FORMS}
    print(LINE.format("page", "ours", "plain", "ratio"))
    for name, pages in {**moving, **forms}.items():
        ours, usual = (cpu_ms(window, draw, pages) for draw in (window._canvas.draw, plain(window._canvas)))
        print(LINE.format(name, *(f"{value:.1f}" for value in (ours, usual, usual / ours))))
        tell(f"{name}: a frame", ours, "ms", at_most=3 if name in moving else 16)
        tell(f"{name}: plain PsychoPy over ours", usual / ours)
    window.close()


if __name__ == "__main__":
    main()
