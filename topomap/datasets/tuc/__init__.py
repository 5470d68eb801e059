"""Recordings in the TUC format: reader, drive, loop candidates, and the map made of them."""
