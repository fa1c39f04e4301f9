"""Results of the group for each dependent variable and questionnaire."""
