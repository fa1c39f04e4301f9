"""Predicted loss of contact on a plate, compared with one-sided contacts."""

import json

import numpy as np
import pytest
from command_line import output
from scipy.signal import lsim, resample
from study_texts import changed, wired

from tactometry.contact import Contact
from tactometry.experiments.bench.preflight import _study
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.felt_effects import pulled_fingers
from tactometry.experiments.study.study_file import load
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.finger import Contactor
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact, one_sided_contacts
from tactometry.stimuli.time_reversal.stimulus.contact_force import FINER, contact_force_n
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.sensation import FocusReading, displacement_at_focus_m
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

SETUP = "setup = { n_transducers = 8, modes_to_hz = 22e3, rate_hz = 50e3, learnt_s = 3e-3, tau_s = 1.5e-3 }"
FOCUS = f"{SETUP}\nf_max_hz = 20e3\nvoltage_max_v = 2e3"
THRESHOLD = load("time-reversal-threshold")[1].decode()
PLAYED = f'pattern = "P0"\n{FOCUS}'
SMALL = THRESHOLD.replace('pattern = "P0"', PLAYED).replace("voltage_peak_v = 200.0", "voltage_peak_v = 2e3")
PRESSED = Contact(1.0)
SCREEN = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3, learnt_s=3e-3, tau_s=1.5e-3)
TIMES, FEW = 32, 8
"""Steps of the contact for one sample of the drive: 71 to a period of the highest mode; of seven contacts 18."""


@pytest.fixture(scope="module")
def study():
    return wired(SMALL)


def contact_course(study, level, force_n):
    """Simulate the finger at the focus with a contact that can open."""
    cell = next(iter(study.cells.values()))
    setup, signal = cell.stimulus.setup, cell.stimulus.at(level)
    n_played = int(np.flatnonzero(signal.samples.any(axis=0))[-1]) + 1
    free_m = emitted(signal, setup.responses_at(*setup.focus_m))[0]
    fine_m, rate_hz = resample(free_m, TIMES * len(free_m)), TIMES * setup.rate_hz
    kept = fine_m[: TIMES * (n_played + 50)]
    return one_sided_contact(setup.screen, setup.focus_m, kept, rate_hz, setup.modes_to_hz, force_n)


def played(level):
    return FocusTrain(SCREEN, f_max_hz=20e3, voltage_max_v=2e4).at(level)


def parts_of_a_tip(loads, signal):
    """Simulate parts that share a force and can each lift off."""
    n_played = int(np.flatnonzero(signal.samples.any(axis=0))[-1]) + 1
    free_m = emitted(signal, SCREEN.responses_at_each(tuple((load.x_m, load.y_m) for load in loads)))
    fine_m = resample(free_m, FEW * free_m.shape[1], axis=1)[:, : FEW * (n_played + 50)]
    shares_n = np.full(len(loads), PRESSED.force_n / len(loads))
    return one_sided_contacts(SCREEN.screen, fine_m, loads, shares_n, FEW * SCREEN.rate_hz, SCREEN.modes_to_hz)


def test_reported_level_is_where_contact_opens(study):
    for finger in pulled_fingers(study)[::2]:
        assert finger.lifts_off
        below, above = (contact_course(study, finger.first_level + step, finger.force_n) for step in (-0.3, 0.3))
        assert not below.apart.any()
        assert above.apart.any()


def test_held_contact_force_equals_time_steps(study):
    cell = next(iter(study.cells.values()))
    signal = cell.stimulus.at(-20.0)
    (force,) = cell.sensation.contact_force_n(signal, Contact(2.0))
    stepped = contact_course(study, -20.0, 2.0).contact_force_n - 2.0
    by_step = np.interp((np.arange(len(stepped)) - 0.5) / TIMES, np.arange(len(force)) / FINER, force)
    assert stepped == pytest.approx(by_step, abs=1e-2 * np.abs(force).max())


def test_dry_run_predicts_contact_of_each_force(tmp_path, capsys):
    file = tmp_path / "s.toml"
    file.write_text(SMALL.replace("levels = [10.0", "levels = [-30.0, 10.0"))
    said = output(capsys, "run", file, "--participant", "P01", "--dry-run")
    assert said.count("dB re 1 um on: at 30 dB re 1 um (focus) the plate pulls the finger (pressed with ") == 3
    record = json.loads(output(capsys, "run", file, "--participant", "P01", "--dry-run", "--json"))
    assert [finger["force_n"] for finger in record["contact"]] == [0.5, 1.5, 3.0]
    firsts = [finger["first_level"] for finger in record["contact"]]
    assert firsts == sorted(firsts)
    simulated = ("simulate", file, "--participants", 1, "--seed", 1, "--out", tmp_path / "d", "--explain")
    assert output(capsys, *simulated).count("contact is lost from ") == 3


def test_check_predicts_contact_loss(tmp_path):
    file = tmp_path / "s.toml"
    faint = SMALL.replace("levels = [30.0]", "levels = [-30.0]")
    file.write_text(faint.replace("levels = [10.0, 14.0, 18.0, 22.0, 26.0, 30.0]", "levels = [-40.0, -30.0]"))
    findings, _ = _study(str(file), allow_code=False)
    told = [finding for finding in findings if finding.part != "study"]  # the study's: what nobody would feel
    assert [finding.part for finding in told] == ["scene", "finger", "finger", "finger"]
    assert all(finding.found.startswith("contact holds: at -30 dB re 1 um (focus)") for finding in told[1:])


def test_burst_lengths_have_first_level():
    at_supply = wired(SMALL.replace("f_max_hz = 20e3", "f_max_hz = 20e3\nsupply_v = 1.5e3"))
    *_, firm = pulled_fingers(at_supply)
    cell = next(iter(at_supply.cells.values()))
    force = cell.sensation.contact_force_n(cell.stimulus.at(firm.first_level), Contact(firm.force_n))
    assert -force.min() == pytest.approx(firm.force_n, rel=0.1)  # a burst is a whole number of samples


def test_study_without_a_plate_reports_no_contact_loss():
    assert pulled_fingers(wire(load("tutorial")[0], "tutorial")) == []
    assert FocusReading(SCREEN).contact_force_n(Signal(np.ones((8, 9)), 50e3, "V"), Contact(0.0)).size == 0


@pytest.fixture(scope="module")
def soft_tip():
    loads = Contactor("soft", 0.02).loads(SCREEN.plate, SCREEN.focus_m, PRESSED.force_n)
    return FocusReading(SCREEN, contactor="soft", diameter_m=0.02), loads


def test_soft_tip_force_is_sum_of_parts(soft_tip):
    reading, loads = soft_tip
    told, stepped = reading.contact_force_n(played(-40.0), PRESSED), parts_of_a_tip(loads, played(-40.0))
    answered = stepped.contact_force_n.sum(axis=0) - PRESSED.force_n
    by_step = np.interp((np.arange(len(answered)) - 0.5) / FEW, np.arange(len(told)) / FINER, told)
    assert answered == pytest.approx(by_step, abs=2e-2 * np.abs(told).max())


def test_soft_tip_lifts_when_all_parts_pull(soft_tip):
    reading, loads = soft_tip
    first = -20 * np.log10(-reading.contact_force_n(played(0.0), PRESSED).min() / PRESSED.force_n)
    assert parts_of_a_tip(loads, played(first + 0.3)).apart.any()
    assert not parts_of_a_tip(loads, played(first - 6.0)).apart.any()  # a part may open below, but not at the half


def test_rigid_tip_force_equals_mass_on_spring():
    *_, tip = Contactor("rigid", 5e-3).loads(SCREEN.plate, SCREEN.focus_m, 2.0)
    force = contact_force_n(SCREEN, played(20.0), [tip])[::FINER]
    plate_m = displacement_at_focus_m(SCREEN, played(20.0), [tip])
    stiffness = tip.stiffness_n_per_m
    fine_m = resample(np.pad(plate_m, (0, len(plate_m))), 2 * FEW * len(plate_m))
    system = ([stiffness / tip.mass_kg], [1.0, 0.0, stiffness / tip.mass_kg])
    _, tip_m, _ = lsim(system, fine_m, np.arange(len(fine_m)) / (FEW * SCREEN.rate_hz))
    answered = stiffness * (fine_m - tip_m)[::FEW]
    n = min(len(force), len(plate_m) - 25)
    assert answered[:n] == pytest.approx(force[:n], abs=2e-2 * np.abs(force).max())


def test_force_loss_reports_each_contactor_and_force():
    text = load("force-loss")[1].decode().replace('duration_s = "500 ms"', f'duration_s = "500 ms"\n{FOCUS}')
    found = pulled_fingers(wired(text.replace("voltage_peak_v = 200.0", "voltage_peak_v = 2e3")))
    assert len(found) == 25
    tips = {f"{kind} {size} mm tip" for kind in ("soft", "rigid") for size in (5, 10)}
    assert {finger.presser for finger in found} == {"finger", *tips}


LOCALISATION = load("time-reversal-localisation")[1].decode()
TWO_FINGERS = changed(
    LOCALISATION,
    {
        "distance_m = [0.010, 0.013, 0.017, 0.022, 0.028, 0.036, 0.050]": "distance_m = [0.010]",
        "f_max_hz = 3e3": f"{SETUP}\nvoltage_max_v = 2e3\nf_max_hz = 20e3",
        "voltage_peak_v = 200.0": "voltage_peak_v = 2e3",
    },
)
TWO_FINGERS = "\n".join(line for line in TWO_FINGERS.splitlines() if not line.startswith('"0.0') or '"0.01"' in line)


def test_coupled_fingers_equal_joint_simulation():
    """Compare with both contacts simulated together, coupled by the plate."""
    study = wired(TWO_FINGERS)
    cell = next(cell for cell in study.cells.values() if cell.condition.factors["place"] == "index")
    setup, signal = cell.stimulus.setup, cell.stimulus.at(-20.0)
    places = [(0.121, 0.093), (0.131, 0.093)]
    loads = [Fingertip().load(at_m, 0.5) for at_m in places]
    free_m = np.stack([emitted(signal, setup.responses_at(*at_m))[0] for at_m in places])
    fine_m = resample(free_m, TIMES * free_m.shape[1], axis=1)[:, : TIMES * (signal.samples.shape[1] + 25)]
    stepped = one_sided_contacts(setup.screen, fine_m, loads, np.full(2, 0.5), TIMES * setup.rate_hz, setup.modes_to_hz)
    told = cell.sensation.contact_force_n(signal, Contact(1.0))
    for answered, force in zip(stepped.contact_force_n - 0.5, told, strict=True):
        by_step = np.interp((np.arange(len(answered)) - 0.5) / TIMES, np.arange(len(force)) / FINER, force)
        assert answered == pytest.approx(by_step, abs=1e-2 * np.abs(told).max())
    alone = contact_force_n(setup, signal, loads[1:])  # beside the focus
    assert np.abs(alone - told[1]).max() > 0.05 * np.abs(alone).max()


def test_contact_is_predicted_for_each_finger():
    index, middle = pulled_fingers(wired(TWO_FINGERS))
    assert (index.presser, middle.presser) == ("finger at index", "finger at middle")
    assert index.force_n == middle.force_n == 0.5
    assert "the plate pulls the finger at index (pressed with 0.5 N) with " in index.line
    assert index.first_level != middle.first_level
