"""Check that what exporting needs is installed: an extra of the installation."""

import importlib

from common.errors import NotInstalledError

NEEDED = "av", "pyarrow"


def check_installed() -> None:
    """NotInstalledError, with the command for it, where the extra `export` is missing."""
    try:
        for module in NEEDED:
            importlib.import_module(module)
    except ImportError as error:
        cure = "pip install 'farhand[export]'"
        raise NotInstalledError(f"to export, PyAV and pyarrow are needed ({error}): {cure}") from error
