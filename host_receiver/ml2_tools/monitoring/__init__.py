"""Latencies, rates and losses of topics, as `latency`, `topics` and `echo` show them."""
