"""Steel members and drawings in, verified machine programs out."""

__version__ = "0.1.0"
