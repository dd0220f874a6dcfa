"""Two programs, or two parts, compared by what they mean.

Bars by the features that the programs make, tables statement by statement.
"""
