"""Runs the page's pure modules in Node, without a browser; skips where there is no Node."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

MODULES = Path(__file__).parents[4] / "local_site" / "console" / "static"


def run(script: str, *values: object) -> Any:
    """What a script returns for `values`; `load` gives it a module of the page by its name."""
    if shutil.which("node") is None:
        pytest.skip("no node to run the page's modules in; on Debian: apt-get install nodejs")
    body = f"const load = (name) => import(`{MODULES.as_uri()}/${{name}}.js`);"
    body += f"const made = await (async (v) => {{ {script} }})(JSON.parse(process.argv[1]));"
    body += "process.stdout.write(JSON.stringify(made));"
    ran = subprocess.run(
        ["node", "--input-type=module", "-e", body, json.dumps(values)], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)
