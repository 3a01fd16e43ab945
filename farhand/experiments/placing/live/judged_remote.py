"""Runs the remote site with the judge in its simulated cell's process.

python -m farhand.experiments.placing.live.judged_remote OUT key=value ...
"""

import sys
from functools import partial
from pathlib import Path

from common.config import load_config
from common.errors import FarhandError
from common.process.log import finish_log
from common.process.service import StopFlag
from farhand.experiments.placing.live.judgement import judged
from remote_site.config import RemoteConfig
from remote_site.runtime.app import run_remote


def main() -> None:
    """Run until SIGTERM; the judgement is in the file OUT then."""
    should_stop = StopFlag()
    should_stop.install()
    try:
        config = load_config(RemoteConfig, None, sys.argv[2:])
        run_remote(config, should_stop, witness=partial(judged, config, Path(sys.argv[1])))
    except FarhandError as error:
        sys.exit(f"farhand: {error}")
    finally:
        finish_log()


if __name__ == "__main__":
    main()
