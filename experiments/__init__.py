"""Study files and their wiring: here stimuli, protocols and analysis meet, and nowhere else.

`study` reads a study file and `wiring` makes sessions of it; `simulating`, `recording` and `replaying` drive them,
`planning` counts them, `checking` and `calibrating` prepare a bench, `exporting` hands data sets on, `validation` says
whether one is sound. The built-in studies lie here as TOML, built-in scenes in `scenes`, what accuracy costs in
`ladders`.
"""
