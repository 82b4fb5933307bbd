# SPDX-License-Identifier: Apache-2.0
"""One line on the error stream: what runs, how far, how long yet."""
import sys


def duration(seconds):
    """'3 min 20 s'"""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 100 else f"{minutes / 60:.1f} h"


def show(text, quiet):
    """Overwrites the line on a terminal, adds one elsewhere."""
    if quiet:
        return
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\x1b[K{text[:110]}")
    else:
        sys.stderr.write(text + "\n")
    sys.stderr.flush()


def close(quiet):
    """Ends the line."""
    if not quiet and sys.stderr.isatty():
        sys.stderr.write("\n")
