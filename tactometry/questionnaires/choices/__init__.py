"""Forms of questions with choices of their own, a data file each; `tactometry.questionnaire` reads them."""
