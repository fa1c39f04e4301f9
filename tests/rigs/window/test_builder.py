"""A Builder experiment with our components, compiled and run by PsychoPy."""

import json

import pytest
from places import ROOT
from script_bench import run_script
from tables import rows_of
from window_sitting import python

from tactometry.questionnaire import load

pytestmark = pytest.mark.slow  # PsychoPy's app and its compiler take ten seconds to load
BUILDER_FILE = ROOT / "tests" / "support" / "builder_file.py"
COMPILE = """
from psychopy import plugins
plugins.activatePlugins()
from psychopy.scripts.psyexpCompile import compileScript
compileScript("felt.psyexp", None, "felt.py")
"""


@pytest.fixture(scope="module")
def compiled(display, tmp_path_factory):
    folder = tmp_path_factory.mktemp("builder")
    python(BUILDER_FILE, "felt.psyexp", cwd=folder, check=True)
    python("-c", COMPILE, cwd=folder, check=True)
    return folder


TOLD = """
import json
from psychopy import plugins
plugins.activatePlugins()
from psychopy import experiment
told = {**experiment.getElementProfiles(), **experiment.getLoopProfiles()}
print(json.dumps({name: list(each["params"]) for name, each in told.items() if each["plugin"] == "tactometry"}))
"""


def test_builder_lists_components_with_their_fields(display, tmp_path):
    told = json.loads(python("-c", TOLD, cwd=tmp_path, check=True).stdout.splitlines()[0])
    components = {"GatedTouchComponent", "TactileStimulusComponent", "QuestionnaireComponent"}
    assert told.keys() == components | {"TactometryLoop"}
    assert all({"name", "study", "bench", "factors"} <= set(fields) for fields in told.values())


@pytest.fixture(scope="module")
def sitting(compiled, display):
    status, _, errors = run_script(compiled, display, "felt.py", ["y", "4", "Return"] * 2000)
    assert status == 0, errors
    return rows_of(compiled / "data.csv")


def test_loop_runs_procedure_levels_until_it_finishes(sitting):
    trials = [row for row in sitting if row["quest.response"]]
    answers = [(row["quest.response"], row["quest.valid"], row["quest.force_mean_n"]) for row in trials]
    assert answers == [("1", "1", "1.0")] * 4
    assert [row["quest.intensity"] for row in trials] == [row["quest.level_delivered"] for row in trials]
    assert [row["quest.ending"] for row in sitting if row["quest.ending"]] == ["censored_below"]


def test_stimulus_and_touch_components_write_rows(sitting):
    [row] = [row for row in sitting if row["buzz.digest"]]
    # a busy machine may lose the sensor, which stops the stimulus
    assert (row["buzz.cut"], row.get("buzz.level_delivered", "")) in (("0", "36"), ("1", ""))
    [felt] = [row for row in sitting if row["felt.valid"]]
    assert felt["felt.level_delivered"] == "30"
    assert felt["felt.valid"] == "1" or felt["felt.invalid_reason"] == "sensor_lost"


def test_questionnaire_component_writes_one_row_per_item(sitting):
    answers = {row["attrakdiff.item"]: row["attrakdiff.response"] for row in sitting if row["attrakdiff.item"]}
    assert answers == {item.id: "4.0" for item in load("attrakdiff").items}


def test_escape_ends_experiment_and_keeps_rows(compiled, display):
    def keys():
        while not heard():
            yield from ("y", "Return")
        yield from ["Escape"] * 1000

    def heard():
        return len(list((compiled / "played").glob("*.npz"))) - n_before >= 2

    n_before = len(list((compiled / "played").glob("*.npz")))
    status, _, errors = run_script(compiled, display, "felt.py", keys())
    assert (status, "Traceback" in errors) == (0, False), errors
    kept = rows_of(max(compiled.glob("data*.csv"), key=lambda path: path.stat().st_mtime))
    assert 1 <= len([row for row in kept if row["quest.response"]]) <= 3
    assert not [row for row in kept if row.get("attrakdiff.item")]
