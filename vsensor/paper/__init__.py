"""The paper that this project comes from: every model and figure of it, running, mended and judged.

*Real Time Monitoring of Long Slender Shaft by Distributed-Lumped Modeling Techniques*. Equation and
figure numbers are the paper's throughout; docs/theory.md derives them and lists what is mended.

| module | holds |
| --- | --- |
| `shaft` | the paper's shaft, load and torque (Table II) |
| `lumped` | two inertias and a spring, eq. (1) to (3) |
| `chain`, `stick_slip` | dry friction with its events located; section III |
| `general_line` | any line with losses as a two-port, eq. (4) to (17) |
| `distributed` | line and load in steps of a round trip, eq. (18) to (25) |
| `exact`, `fine` | the same system in closed form, and stepped finely by the program's own kernels |
| `stress` | shear stress at the end and along the shaft |
| `comparison` | all of them, for shafts of 500 to 8000 m |
| `cases` | three systems published by others |
| `values`, `figures`, `page`, `publish` | numbers, pictures and the page that tells of them |
"""
