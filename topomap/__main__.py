"""`python -m topomap` is the command line."""

from topomap.cli.main import main

main()
