"""The work on one part of a bar: a file for each kind of it, and `work` that asks them all."""
