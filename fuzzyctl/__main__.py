"""Run `python -m fuzzyctl` as the command `fuzzyctl`; editors start the server so."""

from fuzzyctl.cli.main import main

if __name__ == "__main__":
    main()
