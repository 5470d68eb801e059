"""The recording bench: how firm a map stays with fewer closures or other settings; table and figure."""
