"""Results judged by the truth.

Trajectories, closures, precision and recall, journeys, statistics, the rows of the ledger, the summary.
"""
