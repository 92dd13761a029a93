"""Speed and error beside what a user would take instead, and the cases that break solvers; for reading, not for tests.

`python -m cablecad.bench planar` and `python -m cablecad.bench hard-cases` print tables.
"""
