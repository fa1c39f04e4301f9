"""`python -m tactometry`."""

from tactometry.cli import main

if __name__ == "__main__":
    main()
