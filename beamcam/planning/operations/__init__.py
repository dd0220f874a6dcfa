"""The kinds of work on a bar, a file each."""
