"""Results for the group, for each dependent value and questionnaire."""
