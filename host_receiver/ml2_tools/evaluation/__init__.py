"""How well a trajectory that is estimated from images alone agrees with the headset's own poses."""
