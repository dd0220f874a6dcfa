"""The setup sheet of a program: what the operator needs to know, on one page.

program, parts, plan -> content (record) -> HTML with playback (page, playback), or PDF (paper)

What is shown of the program (pictures, operations, times, playback) comes from its text as the
read-back interprets it; from the plan come the ledger and the stations that tools go to.
"""
