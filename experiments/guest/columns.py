"""What a touch, a stimulus or a trial leaves in the rows of a PsychoPy script: names as in a table of trials."""

from tactometry.protocols.tasks.task import Reply, TrialOutcome
from tactometry.questionnaire import ChoiceForm, Questionnaire
from tactometry.session.answer import Played, Touched

Values = dict[str, float | str]
OF_A_TOUCH = (
    "level_delivered",
    "force_mean_n",
    "force_sd_n",
    "force_in_band",
    "speed_mean_m_per_s",
    "speed_in_band",
    "n_gaps",
)


def _stated(values: dict[str, float | str | None]) -> Values:
    """What is known, truths as 1 and 0: a cell that is left out stays empty."""
    known = {name: value for name, value in values.items() if value is not None}
    return {name: int(value) if isinstance(value, bool) else value for name, value in known.items()}


def of_touch(touch: Touched) -> Values:
    """The row of a touch.

    >>> of_touch(Touched(0.0, 40.0, "c0ffee", force_mean_n=0.52, valid=False, invalid_reason="timeout"))
    {'level_delivered': 40.0, 'force_mean_n': 0.52, 'valid': 0, 'invalid_reason': 'timeout'}
    """
    measured = {name: getattr(touch, name) for name in OF_A_TOUCH}
    return _stated(measured | {"valid": touch.valid, "invalid_reason": touch.invalid_reason})


def of_stimulus(played: Played) -> Values:
    """The row of a stimulus that played beside.

    >>> of_stimulus(Played(0.0, 40.0, "c0ffee"))
    {'level_delivered': 40.0, 'digest': 'c0ffee'}
    """
    level, n_gaps = played.level_delivered, played.n_gaps
    return _stated({"level_delivered": level, "n_gaps": n_gaps, "digest": played.digest or None})


def of_trial(outcome: TrialOutcome) -> Values:
    """The row of a trial: the touch whose level counts, and the first answer.

    >>> of_trial(TrialOutcome((), replies=()))
    {'valid': 0}
    """
    touch = outcome.stimulus
    reply = outcome.replies[0] if outcome.replies else None
    answered = {} if reply is None else {"response": reply.response, "correct": outcome.correct}
    latency_s = None if reply is None or reply.answer is None else reply.answer.latency_s
    judged = {"valid": outcome.valid, "invalid_reason": outcome.invalid_reason, "target": outcome.target}
    felt = {} if touch is None else of_touch(touch)
    return felt | _stated({**judged, **answered, "latency_s": latency_s})


def of_reply(form: Questionnaire | ChoiceForm, reply: Reply) -> dict[str, float | str | None]:
    """The row of an item of a questionnaire; of questions about a person with the category, in English if it has that.

    >>> from tactometry.questionnaire import load_choices
    >>> of_reply(load_choices("demographics"), Reply(None, 1.0, item="handedness"))
    {'item': 'handedness', 'response': 1.0, 'category': 'right'}
    """
    row: dict[str, float | str | None] = {"item": reply.item, "response": reply.response}
    if not isinstance(form, ChoiceForm):
        return row
    asked = None if reply.item is None else form.item(reply.item)
    code = 0 if asked is None or reply.response is None or asked.bounds is not None else int(reply.response)
    return row | {"category": "" if asked is None else asked.category(code)}
