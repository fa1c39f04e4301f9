"""The course of a procedure under given answers."""


def follow(rule, answers):
    """The levels that a rule asked for, and the rule as the answers leave it."""
    levels = []
    for answer in answers:
        levels.append(rule.level)
        rule = rule.after(answer)
    return levels, rule
