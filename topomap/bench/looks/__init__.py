"""What places look like, seen again or not: the measurement behind the closure engine's looks."""
