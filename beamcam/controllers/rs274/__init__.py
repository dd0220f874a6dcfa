"""RS274/NGC: its blocks, its modal interpreter, and what LinuxCNC and grbl take of it."""
