"""`python -m transport` is the command `transport`."""

from transport.command.cli import main

if __name__ == "__main__":
    main()
