"""Planning: parts and a machine in, a `Plan` out, or every reason why there is none.

`beam.plan_oriented` plans bars (`beam.plan_bar` as their parts lie) and `sheet.plan_sheet` sheets;
neither loads what the other needs. Which pieces of a request share a bar or a sheet say `stock` and
`sheet_rows`.
"""
