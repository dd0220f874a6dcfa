"""Batches: many files in, a folder of programs and an account out.

    find -> run -> workers (here, processes, a cluster) -> rows

`find.find_inputs` says which files are meant, `run.run` posts them and gives a row for each.
"""
