"""The protocol session of one headset, from HELLO to BYE."""
