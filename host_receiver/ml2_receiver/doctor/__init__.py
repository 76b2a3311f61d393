"""What keeps a receiver on this machine from working."""
