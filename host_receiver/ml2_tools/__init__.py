"""Works on the topics and recordings of ml2_receiver. Uses only its public modules."""
