"""Programs read back, and compared with the parts that they should make.

It shares no code and no decision with planning, motion or the emitters, so that a fault of theirs
cannot hide in it. The meaning of a text comes from `controllers`; what the machine makes of it, and
whether that is the part, here: `bars` of saw and drill, `sheets`, `st` and `steps` of what follows
contours.
"""
