"""Curves in the plane: mathematics, no steel. Lengths in mm."""
