"""Topics as the thesis's scripts had them, for programs written against those."""
