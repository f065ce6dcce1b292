"""Entry point of `python -m transport`, the same as the command `transport`."""

from transport.cli.commands import main

if __name__ == "__main__":
    main()
