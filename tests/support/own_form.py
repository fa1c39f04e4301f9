"""A questionnaire of a study's own, asked at the end of its sessions."""

OWN_FORM = """
[inquiries.end]
form = "mine"

[forms.mine]
title = "Mine"
reference = "none"
low = 0.0
high = 1.0
score_low = -1.0
score_high = 1.0
items = [
  { id = "A", dimension = "D", order = 1, poles = { en = ["Bad", "Good"] } },
  { id = "B", dimension = "D", order = 2, reversed = true, poles = { en = ["Dull", "Bright"] } },
]

[forms.mine.dimensions.D]
min_answered = 1
"""
