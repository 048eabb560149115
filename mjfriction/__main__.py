"""``python -m mjfriction``, the same as the command."""

from mjfriction.cli.main import run

if __name__ == "__main__":
    run()
