"""Reports: what people read about parts and runs."""
