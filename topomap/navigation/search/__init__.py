"""Which way a lost robot drives: the one on which its places part soonest, told by the map alone."""
