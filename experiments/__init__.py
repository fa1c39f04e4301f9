"""Study files and their wiring to stimuli, protocols and analysis.

`study` reads a study file, wires its cells and plans its sessions; `sessions` records or simulates them; `bench` reads
and prepares a bench; `data_sets` replays, validates and exports what was recorded. The built-in studies lie here as
TOML, built-in scenes in `scenes`, accuracy problems in `accuracy`, reproduced results of the thesis in
`thesis`, and in `harness` what they share with the benchmarks.
"""
