"""Small mistakes made on purpose in the source: each should be noticed by a test."""
