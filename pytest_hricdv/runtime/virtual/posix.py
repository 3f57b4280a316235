"""What of POSIX this system has."""

from importlib.util import find_spec

HAS_TERMINALS = all(find_spec(name) is not None for name in ("fcntl", "termios"))
"""It has terminals of POSIX, which nodes can be given; Windows has none."""
