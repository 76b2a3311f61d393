"""One module per subcommand: add_parser(subparsers) declares it and sets its function as `run`."""
