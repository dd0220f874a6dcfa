"""The axes of a machine over time, from the events of a program.

text -> events (controllers) -> trace (program) -> rows of it, or registers sent by Modbus
                                bars by way of the stretches of the cell (course)
"""
