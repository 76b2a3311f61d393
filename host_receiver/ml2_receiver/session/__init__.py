"""The sessions of headsets, from HELLO to BYE, and the interfaces of sinks and graphs."""
