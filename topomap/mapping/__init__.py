"""The map of snapshots: `Mapper` makes a `TopoMap` reading by reading, `mapfile` keeps it.

`Track` is the route as it grows; `PoseGraph` is what files of other programs hold.
"""
