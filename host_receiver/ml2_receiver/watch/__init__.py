"""What other commands see of a running receiver."""
