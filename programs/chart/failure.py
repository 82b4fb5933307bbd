# SPDX-License-Identifier: Apache-2.0
"""What ends the program with one line and exit code 2."""


class InputError(Exception):
    """Wrong arguments, scenes or files; the message is one line that names what is wrong."""
