"""The error of this package."""


class GenerateError(Exception):
    """A model, a belief space, a file of tests or a parameter that tests cannot be generated from.

    The message says what was expected, what was found and, if there is one, the place as `file:line:column`.
    """
