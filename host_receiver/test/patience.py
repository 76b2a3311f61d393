"""How long tests wait for what has to come, on however slow a machine."""

PATIENCE_S = 20.0
