"""The shipped questionnaires as TOML: items, scales, reversals and languages; `tactometry.questionnaire` reads them."""
