"""Step tables as rows of time and words: text and bytes (rows), arrays of C (header)."""
