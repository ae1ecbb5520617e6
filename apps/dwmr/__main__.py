"""Run `python -m dwmr` as the command `dwmr`."""

from dwmr.cli.main import main

if __name__ == "__main__":
    main()
