"""Two variants of one method, compared over the grid of a simulated room: what `topomap bench homing` does inside."""

from topomap.app.views import world_recipe
from topomap.bench.homing.bench import BenchSettings, bench
from topomap.bench.homing.contestant import Pairwise
from topomap.bench.homing.table import HEADINGS, cells
from topomap.bench.pool import Store, workers
from topomap.vision.homing.moment import Moment

variants = [Pairwise("perimeter", Moment(2.0, "equal")), Pairwise("area", Moment(2.0, "equal", "area"))]
with workers(1, Store(None)) as hands:
    [table] = bench([world_recipe("a1original", 0)], None, variants, BenchSettings(starts=2), hands, lambda: None)
for row in table.rows:
    print(", ".join(f"{name}: {cell}" for name, cell in zip(HEADINGS, cells(row), strict=True)))
