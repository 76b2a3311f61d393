"""This receiver's key and certificate, and the devices it is paired with."""
