"""Pictures of parts, programs and profiles.

part (model)                         -> scene -> SVG, PDF (reportlab) or PNG (Pillow)
machined features (verify), trace (simulate)

A scene is data: lines, circles and texts on paper, each of a named style. A picture of a program is
drawn from what the read-back's interpreter found in its text, and carries the hash of that text.
"""
