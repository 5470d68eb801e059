"""Log records from `StepRecord`s, and `RunData` from a log; nobody else translates between the two."""
