"""The pose graph bench: false closures injected, peers beside the back end, table and figure."""
