"""The way home: `Navigator` makes one step of the whole stack, `run` repeats it.

Planner, pilot, localiser, traveller, mission, arrival.
"""
