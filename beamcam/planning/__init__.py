"""Planning: parts and a machine in, a `Plan` out, or every reason why there is none.

`orientation.plan_oriented` plans bars (`beam.plan_bar` as their parts lie) and `sheet.plan_sheet`
sheets; neither loads what the other needs.
"""
