"""The subcommands that work on topics and recordings."""
