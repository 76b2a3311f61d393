"""The configuration: its file, its rules, and the streams that follow from it."""
