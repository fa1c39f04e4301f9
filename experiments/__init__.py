"""Study files and their wiring: here stimuli, protocols and analysis meet, and nowhere else.

`study` reads a study file, wires its cells and plans its sessions; `sessions` records or simulates them; `bench` reads
and prepares a bench; `data_sets` replays, validates and exports what was recorded. The built-in studies lie here as
TOML, built-in scenes in `scenes`, what accuracy costs in `ladders`, what comes out of the thesis in `thesis`.
"""
