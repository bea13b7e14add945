"""InputError: the exception for whatever a user can get wrong."""


class InputError(ValueError):
    """Something given from outside is wrong; the message says what was given and what was wanted.

    The command line prints it as one line on stderr and leaves with exit code 2.
    """
