"""The commands: thin wrappers that print. One module each, its click command is `command`."""
