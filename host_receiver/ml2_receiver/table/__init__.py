"""The stream table: every stream, topic, key and mode."""
