"""Who may connect: this receiver's key, the devices it is paired with, and pairing itself."""
