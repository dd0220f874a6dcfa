"""Every noun that crosses a stage: `Part`, `Plan`, `Program`, and the JSON form of a part."""
