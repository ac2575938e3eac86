"""`python -m twonav_cli` is the same as `twonav`."""

from twonav_cli.terminal.app import main

if __name__ == "__main__":
    main()
