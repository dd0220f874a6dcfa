"""The axes of a cell over time, from the events of a program.

events -> course (stretches of time) -> trace as CSV, or registers sent by Modbus
"""
