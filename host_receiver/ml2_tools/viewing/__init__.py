"""Shows a running receiver's streams on a page in a browser of this machine."""
