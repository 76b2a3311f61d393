"""What the user asks for: the file, its rules, and the streams that follow from it."""
