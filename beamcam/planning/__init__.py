"""Planning: parts and a machine in, a `Plan` out, or every reason why there is none.

`beam.plan_bar` plans bars, `sheet.plan_sheet` sheets; neither loads what the other needs.
"""
