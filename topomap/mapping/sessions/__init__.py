"""More than one drive in one map: where another one begins, two maps merged, what adds nothing taken out."""
