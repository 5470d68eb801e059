"""Places: when a snapshot is kept, the index of similar ones, recognition, the view cache."""
