"""The sessions of headsets, from HELLO to BYE, and the interface of sinks."""
