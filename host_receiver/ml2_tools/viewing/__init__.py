"""Shows and steers a running receiver on a page in a browser of this machine."""
