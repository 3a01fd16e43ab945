"""The arm of the remote site's tests is found by name."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
