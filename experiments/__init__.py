"""Study files and their wiring to stimuli, protocols and analysis.

`study` reads a study file, wires its cells and plans its sessions; `sessions` records or simulates them; `bench` reads
and prepares a bench; `data_sets` replays, validates and exports recorded data. The built-in studies are TOML files in
this folder. `scenes` contains built-in scenes, `accuracy` accuracy problems, `thesis` reproduced results of the thesis,
and `harness` code shared with the benchmarks.
"""
