"""The course of a procedure under given answers."""


def follow(rule, answers):
    """Return the levels that a rule asked for until it ended, and the rule after these answers."""
    levels = []
    for answer in answers:
        if rule.finished:
            break
        levels.append(rule.level)
        rule = rule.after(answer)
    return levels, rule
