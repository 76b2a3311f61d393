"""The stream table, and what the user asks for."""
