"""Rules that weigh a grid of psychometric functions: QUEST, QUEST+, psi."""
