"""The figures of a run, one file each, and the catalogue that the report shows."""
