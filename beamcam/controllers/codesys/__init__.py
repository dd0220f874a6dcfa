"""CODESYS SoftMotion CNC: its blocks, its modal interpreter, and the curves that it knows."""
