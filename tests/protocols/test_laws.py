"""Properties of every stimulus, procedure, protocol, observer and rig."""

import math
from dataclasses import replace

import catalogue
import msgspec
import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings, strategies as st
from memory import Memory
from soak import SOAK

from tactometry.errors import Diverged, InvalidParameter
from tactometry.records.journal import decode_entry, encode_entry
from tactometry.session.replay import Replay
from tactometry.session.request import Record
from tactometry.session.run import replay, run

seeds = st.integers(0, 2**32 - 1)
N_SESSIONS = 20 if SOAK else 2
per_stimulus = pytest.mark.parametrize("stimulus", catalogue.STIMULI.values(), ids=catalogue.STIMULI)
in_volts = {name: stimulus for name, stimulus in catalogue.STIMULI.items() if stimulus.level_unit == "dB re 1 V"}
per_voltage = pytest.mark.parametrize("stimulus", in_volts.values(), ids=in_volts)
per_procedure = pytest.mark.parametrize("procedure", catalogue.PROCEDURES.values(), ids=catalogue.PROCEDURES)
per_scene = pytest.mark.parametrize("scene", catalogue.SCENES.values(), ids=catalogue.SCENES)
per_protocol = pytest.mark.parametrize("protocol", catalogue.PROTOCOLS.values(), ids=catalogue.PROTOCOLS)
per_observer = pytest.mark.parametrize("observer", catalogue.OBSERVERS.values(), ids=catalogue.OBSERVERS)
per_rig = pytest.mark.parametrize("rig", catalogue.RIG_MAKERS.values(), ids=catalogue.RIG_MAKERS)


@per_stimulus
@given(low=st.floats(-40, 45), higher_by=st.floats(0.01, 20))
def test_a_higher_level_has_a_higher_peak(stimulus, low, higher_by):
    assert stimulus.at(low).peak < stimulus.at(low + higher_by).peak


@per_voltage
@given(level=st.floats(-100, 46))
def test_the_peak_never_passes_what_the_level_states(stimulus, level):
    assert stimulus.at(level).peak <= 10 ** (level / 20) * (1 + 1e-12)


@per_voltage
def test_a_stimulus_starts_and_ends_at_rest(stimulus):
    samples = stimulus.at(40.0).samples
    assert np.abs(samples[:, [0, -1]]).max() <= 1e-2 * np.abs(samples).max()


@per_stimulus
def test_the_same_level_gives_the_same_samples(stimulus):
    assert stimulus.at(20.0).digest() == stimulus.at(20.0).digest()


@per_stimulus
@pytest.mark.parametrize("level", [math.nan, math.inf, 1e6])
def test_a_level_without_a_finite_signal_is_refused(stimulus, level):
    with pytest.raises(InvalidParameter, match="found .*expected"):
        stimulus.at(level)


def run_of(plan):
    return plan.run({name: catalogue.GIVEN[name] for name in plan.given})


@per_scene
def test_scene_runs_are_repeatable(scene):
    once, again = run_of(scene.resolve()), run_of(scene.resolve())
    for output in scene.outputs:
        np.testing.assert_array_equal(once[output], again[output])
    assert scene.resolve() == scene.resolve()


@per_scene
@given(data=st.data())
@settings(max_examples=5)
def test_scene_is_independent_of_effect_and_contact_order(scene, data):
    effects, contacts = (data.draw(st.permutations(part)) for part in (scene.effects, scene.contacts))
    assert replace(scene, effects=tuple(effects), contacts=tuple(contacts)).resolve() == scene.resolve()


@per_scene
@given(accuracy=st.floats(1e-4, 0.5), looser=st.floats(1.0, 2.0))
@examples(20)
def test_lower_accuracy_is_met_without_higher_cost(scene, accuracy, looser):
    fine, loose = (replace(scene, accuracy=value).resolve() for value in (accuracy, accuracy * looser))
    assert fine.error <= accuracy
    assert loose.n_operations <= fine.n_operations


@per_procedure
def test_a_procedure_is_not_changed_by_a_response(procedure):
    before = procedure
    procedure.after(1)
    assert procedure == before


@per_procedure
@pytest.mark.parametrize("response", [None, math.nan, 2, 0.5, "1", -1])
def test_procedure_rejects_invalid_response(procedure, response):
    with pytest.raises(InvalidParameter, match="expected 1"):
        procedure.after(response)


@per_procedure
def test_finished_procedure_rejects_response(procedure):
    while not procedure.finished:
        procedure = procedure.after(0)
    with pytest.raises(InvalidParameter, match="after the end of the procedure"):
        procedure.after(1)


@per_observer
@given(level_db=st.floats(-1000, 1000) | st.just(-math.inf) | st.just(math.inf))
def test_d_prime_is_finite_and_not_negative(observer, level_db):
    assert 0 <= observer.d_prime(level_db) <= 1e6


@per_rig
@per_protocol
def test_every_protocol_completes_on_every_rig(protocol, rig):
    memory = Memory()
    run(protocol(np.random.default_rng(1)), rig(), memory)
    assert memory.finished
    assert memory.trials


@per_protocol
@given(seed=seeds)
@settings(max_examples=N_SESSIONS)
def test_a_session_replays_through_its_journal_lines(protocol, seed):
    memory = Memory()
    run(protocol(np.random.default_rng(seed)), catalogue.simulated(seed), memory)
    entries = [decode_entry(msgspec.json.decode(encode_entry(*entry))) for entry in memory.entries]
    replay(protocol(np.random.default_rng(seed)), Replay(entries))
    assert [r.trial for r, _ in entries if isinstance(r, Record)] == memory.trials


@per_protocol
@given(seed=seeds, part=st.floats(0, 1))
@settings(max_examples=N_SESSIONS)
def test_a_resumed_session_equals_the_uninterrupted_one(protocol, seed, part):
    whole = Memory()
    run(protocol(np.random.default_rng(seed)), catalogue.simulated(seed), whole)
    ends = [0, *(n for n, (request, _) in enumerate(whole.entries, 1) if isinstance(request, Record))]
    resumed = Memory(whole.entries[: ends[int(part * (len(ends) - 1))]])
    run(protocol(np.random.default_rng(seed)), catalogue.simulated(seed), resumed)
    assert resumed.entries == whole.entries


@per_protocol
def test_replay_rejects_truncated_and_longer_recordings(protocol):
    memory = Memory()
    run(protocol(np.random.default_rng(1)), catalogue.simulated(), memory)
    entries = memory.entries
    for changed, message in ((entries[:-1], "has ended"), ([*entries, entries[-1]], "continues with")):
        with pytest.raises(Diverged, match=rf"line \d+: the recording {message}"):
            replay(protocol(np.random.default_rng(1)), Replay(changed))
