"""Whether a recording is fit to be used: gaps, stamps, pairs, transforms, latency."""
