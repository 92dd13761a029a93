"""Speed and error beside what a user would take instead, and the cases that break solvers: `cablecad bench`.

A stage (`stage`) measures and gives tables (`table`); rivals take turns in one run (`clock`); errors are taken against
truth that mpmath gave (`truth`), never against another result of cablecad's; what may kill the process runs in a copy
of it (`sandbox`). `run` runs stages, `report` and `plot` write what they gave, `terminal` shows it.
"""
