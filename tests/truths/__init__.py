"""Fixed truths, each held by a stranger: figures worked out by hand, or another tool.

What planner and read-back share (`model/`, `machine/`, `geometry/`, the shipped machine files)
neither of them can find fault with. Here nothing is worked out by the code that is tested, and no
golden file is read. `benchmarks/truths.py` makes each of them untrue and looks which test sees it.
"""
