"""One module per verb of the command line: ``declare(parser)`` names its options, its handler does the work."""
