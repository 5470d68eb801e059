"""Loop closures: claims in, verdicts out, by one engine with a list of tests.

ClosureEngine (engine), its tests (closure_tests), and who brings it claims: Batch (a pose graph's all at once),
AlongDrive (a recording's as its drive goes on), Closing (a robot's own, one a step).
"""
