"""Many scenes: rows of a table, points of a grid or scene files, built or solved, with one report a row.

`rows` says what a row is, `table` and `grid` where rows come from, `keys` and `inputs` what is known of all of them,
`task` what is done with some in whatever process, `pool` holds processes that may die, `schedule` hands the tasks out
and survives what happens to them, `journal` and `results` keep what came out, and `run` tells the whole story.
"""

from cablecad.batch.grid import grid_rows
from cablecad.batch.pool import WorkerPool
from cablecad.batch.rows import Row, scene_rows
from cablecad.batch.run import Standing, run_batch
from cablecad.batch.summary import Summary
from cablecad.batch.table import table_rows

__all__ = ["Row", "Standing", "Summary", "WorkerPool", "grid_rows", "run_batch", "scene_rows", "table_rows"]
