"""Where topics go: an interface, what stands before it, and what the receiver says itself."""
