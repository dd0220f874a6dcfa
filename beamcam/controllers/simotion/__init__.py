"""Trigger programs, of SIMOTION or plain: their fixed part compared, the job in them read.

text -> fixed part, byte by byte -> operations (job)
machine -> fixed part, parsed, checked and run with simulated axes, once (trial)
Structured Text: lexer -> parser, or plain (syntax) -> names, types, bounds (checker) -> interpreter
commands of axes: cutting_table, or motion_blocks where they are function blocks of PLCopen
"""
