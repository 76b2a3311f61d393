"""Tables that config/generate.py writes."""
